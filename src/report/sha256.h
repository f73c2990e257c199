// SHA-256 (FIPS 180-4): names files in caches by what they were made of.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace voxcone {

class Sha256 {
  public:
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
    void block(const std::uint8_t* data);

    std::array<std::uint32_t, 8> state_ = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                           0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    std::array<std::uint8_t, 64> pending_{};
    std::uint64_t bytes_ = 0;
};

}  // namespace voxcone
