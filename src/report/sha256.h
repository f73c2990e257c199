// SHA-256 (FIPS 180-4): names files in caches by what they were made of.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <type_traits>

struct evp_md_ctx_st;

namespace voxcone {

class Sha256 {
  public:
    Sha256();

    Sha256& add(const void* data, std::size_t bytes);

    /// The length goes first, so that "a", "bc" and "ab", "c" differ.
    Sha256& text(std::string_view text);

    /// Bytes of a number as they are in memory. Not for structs, whose padding is anything.
    template <class T>
    Sha256& number(T value) {
        static_assert(std::is_arithmetic_v<T>);
        return add(&value, sizeof(value));
    }

    /// 64 hexadecimal digits. Nothing may be added afterwards.
    std::string hex();

  private:
    struct Free {
        void operator()(evp_md_ctx_st* context) const;
    };
    std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// Of the running program's own file: measurements by another build are other measurements.
std::string sha256OfProgram();

}  // namespace voxcone
