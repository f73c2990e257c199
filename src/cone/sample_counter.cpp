#include "cone/sample_counter.h"

#include "cascade/buffers.h"
#include "gl/buffer.h"

namespace voxcone {

std::uint64_t SampleCounter::count(const std::function<void(gl::Program&)>& dispatch) {
    if (!program_) {
        defines_["COUNT_SAMPLES"] = "1";
        program_ = shaders_->compute(path_, defines_);
    }
    gl::Buffer words(kSampleWords * sizeof(std::uint32_t));
    words.clear();
    words.bindBase(GL_SHADER_STORAGE_BUFFER, kSampleStorage);
    dispatch(program_);
    gl::memoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    const auto count = words.read<std::uint32_t>();
    return std::uint64_t{count[1]} << 32 | count[0];
}

}  // namespace voxcone
