#include "report/sha256.h"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <vector>

#include "core/check.h"

namespace voxcone {

void Sha256::Free::operator()(evp_md_ctx_st* context) const {
    EVP_MD_CTX_free(context);
}

Sha256::Sha256() : context_(EVP_MD_CTX_new()) {
    VOXCONE_CHECK(context_ && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1, "SHA-256 is not there");
}

Sha256& Sha256::add(const void* data, std::size_t bytes) {
    VOXCONE_CHECK(EVP_DigestUpdate(context_.get(), data, bytes) == 1, "{} bytes", bytes);
    return *this;
}

Sha256& Sha256::text(std::string_view text) {
    return number(static_cast<std::uint64_t>(text.size())).add(text.data(), text.size());
}

std::string Sha256::hex() {
    std::array<unsigned char, 32> digest{};
    unsigned length = 0;
    VOXCONE_CHECK(EVP_DigestFinal_ex(context_.get(), digest.data(), &length) == 1 && length == digest.size(),
                  "{} bytes", length);
    std::string out;
    for (const unsigned char byte : digest) out += fmt::format("{:02x}", byte);
    return out;
}

std::string sha256OfProgram() {
    Sha256 hash;
    std::ifstream file("/proc/self/exe", std::ios::binary);
    std::vector<char> buffer(1 << 20);
    while (file.read(buffer.data(), static_cast<std::streamsize>(buffer.size())), file.gcount() > 0)
        hash.add(buffer.data(), static_cast<std::size_t>(file.gcount()));
    return hash.hex();
}

}  // namespace voxcone
