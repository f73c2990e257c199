// Shuffled, Owen-scrambled Sobol points in padded sets of four dimensions (Burley, "Practical Hash-based Owen
// Scrambling", JCGT 9(4), 2020), with Vegdahl's constants for the Laine–Karras permutation.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <glm/glm.hpp>

namespace voxcone {

/// Mixes all bits of `x` (the finalizer "lowbias32" of Wellons' hash-prospector).
constexpr std::uint32_t hashBits(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

constexpr std::uint32_t hashCombine(std::uint32_t seed, std::uint32_t value) {
    return hashBits(seed ^ (hashBits(value + 0x9e3779b9u) + (seed << 6) + (seed >> 2)));
}

/// [0, 1) from the upper 24 bits.
constexpr float unitFloat(std::uint32_t bits) {
    return static_cast<float>(bits >> 8) * 0x1p-24f;
}

namespace sobol {

/// One dimension as four tables of XOR-ed direction numbers, one table a byte of the index.
using Dimension = std::array<std::array<std::uint32_t, 256>, 4>;

/// `degree`, `a` and the first direction numbers `m` of Joe and Kuo's table; degree 0 is van der Corput's sequence.
constexpr Dimension makeDimension(int degree, std::uint32_t a, std::array<std::uint32_t, 3> m) {
    std::array<std::uint32_t, 32> v{};
    for (int i = 0; i < 32; ++i) {
        const auto k = static_cast<std::size_t>(i);
        if (degree == 0) {
            v[k] = 1u << (31 - i);
        } else if (i < degree) {
            v[k] = m[k] << (31 - i);
        } else {
            const auto s = static_cast<std::size_t>(degree);
            v[k] = v[k - s] ^ (v[k - s] >> degree);
            for (std::size_t j = 1; j < s; ++j)
                if ((a >> (s - 1 - j)) & 1u) v[k] ^= v[k - j];
        }
    }
    Dimension tables{};
    for (std::size_t byte = 0; byte < 4; ++byte)
        for (std::size_t value = 0; value < 256; ++value)
            for (std::size_t bit = 0; bit < 8; ++bit)
                if ((value >> bit) & 1u) tables[byte][value] ^= v[8 * byte + bit];
    return tables;
}

inline constexpr std::array<Dimension, 4> kDimensions{makeDimension(0, 0, {}), makeDimension(1, 0, {1, 0, 0}),
                                                      makeDimension(2, 1, {1, 3, 0}), makeDimension(3, 1, {1, 3, 1})};

constexpr std::uint32_t point(std::uint32_t index, std::size_t dimension) {
    const Dimension& t = kDimensions[dimension];
    return t[0][index & 255u] ^ t[1][(index >> 8) & 255u] ^ t[2][(index >> 16) & 255u] ^ t[3][index >> 24];
}

constexpr std::uint32_t reverseBits(std::uint32_t x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    return (x >> 16) | (x << 16);
}

/// Owen scrambling: every bit is flipped by a hash of the bits above it.
constexpr std::uint32_t owenScramble(std::uint32_t x, std::uint32_t seed) {
    x = reverseBits(x);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reverseBits(x);
}

}  // namespace sobol

/// The points of one path: a function of (seed, index, set) alone, so that threads cannot change a picture.
class Sampler {
  public:
    /// `seed` names the sequence (pixel, half, …), `index` the path in it.
    Sampler(std::uint32_t seed, std::uint32_t index) : seed_(seed), index_(index) {}

    /// Four numbers in [0, 1), stratified together over consecutive indices of the same seed.
    glm::vec4 set(std::uint32_t number) const {
        const std::uint32_t seed = hashCombine(seed_, number);
        const std::uint32_t shuffled = sobol::owenScramble(index_, seed);
        glm::vec4 result;
        for (int k = 0; k < 4; ++k) {
            const auto dimension = static_cast<std::uint32_t>(k);
            result[k] = unitFloat(sobol::owenScramble(sobol::point(shuffled, dimension), hashCombine(seed, dimension)));
        }
        return result;
    }

    /// Seed for decisions that are hashed rather than stratified, such as those of stochastic transparency.
    std::uint32_t hashed(std::uint32_t number) const { return hashCombine(hashCombine(seed_, ~number), index_); }

  private:
    std::uint32_t seed_, index_;
};

}  // namespace voxcone
