#include "frame/cascade_view.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/check.h"
#include "gl/bindings.h"

namespace voxcone {

namespace {

gl::Defines definesOf(const GBuffer& gbuffer, const Voxels& voxels) {
    gl::Defines defines = gbuffer.defines();
    defines["CASCADES"] = voxels.layout.levels > 1 ? "1" : "0";
    return defines;
}

}  // namespace

CascadeView::CascadeView(const gl::ShaderLibrary& shaders, const GBuffer& gbuffer, const Voxels& voxels)
    : program_(shaders.compute("frame/cascade_view.comp", definesOf(gbuffer, voxels))) {
    resize(gbuffer.width(), gbuffer.height());
}

void CascadeView::resize(int width, int height) {
    picture_ = gl::Texture::create2D(GL_RGBA32F, width, height);
}

const gl::Texture& CascadeView::draw(const GBuffer& gbuffer, const Voxels& voxels) {
    gbuffer.bind(program_, gl::kPassTextureUnit);
    setContainmentUniforms(program_, voxels);
    program_.set("u_inverseVoxelSize", static_cast<float>(1 / voxels.layout.voxelSize));
    gl::memoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    picture_.bindImage(0, 0, GL_WRITE_ONLY);
    program_.set("u_picture", 0);
    gl::dispatch(program_, gl::groupsFor(picture_.width(), 8), gl::groupsFor(picture_.height(), 8), 1);
    gl::memoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    return picture_;
}

Seam CascadeView::seam(const Image& finer, const Image& coarser, const Image& levels) {
    VOXCONE_CHECK(levels.channels == 4 && finer.data.size() == coarser.data.size() && finer.width == levels.width &&
                      finer.height == levels.height,
                  "{} channels of levels", levels.channels);
    struct Sum {
        double difference = 0, square = 0, finer = 0;
        std::uint64_t pixels = 0;
    };
    std::array<Sum, 8> sums;
    Seam out;
    out.picture = Image(finer.width, finer.height, 1);
    for (std::size_t i = 0; i < out.picture.data.size(); ++i) {
        const float level = levels.data[4 * i + 3], whole = std::floor(level);
        if (level <= whole || level < 0) continue;
        const auto mean = [&](const Image& image) {
            double sum = 0;
            for (int c = 0; c < image.channels; ++c) {
                const auto n = static_cast<std::size_t>(image.channels);
                sum += static_cast<double>(image.data[n * i + static_cast<std::size_t>(c)]);
            }
            return sum / image.channels;
        };
        const double a = mean(finer), b = mean(coarser);
        if (a + b > 0) out.picture.data[i] = static_cast<float>((b - a) / (0.5 * (a + b)));
        Sum& sum = sums[static_cast<std::size_t>(whole)];
        sum.difference += b - a;
        sum.square += (b - a) * (b - a);
        sum.finer += a;
        ++sum.pixels;
    }
    for (std::size_t l = 0; l < sums.size(); ++l) {
        const Sum& sum = sums[l];
        if (sum.pixels == 0 || sum.finer <= 0) continue;
        const auto n = static_cast<double>(sum.pixels);
        out.steps.push_back(
            {static_cast<int>(l), sum.pixels, sum.difference / sum.finer, std::sqrt(sum.square / n) / (sum.finer / n)});
    }
    return out;
}

}  // namespace voxcone
