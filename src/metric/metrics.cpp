#include "metric/metrics.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/check.h"
#include "core/error.h"
#include "metric/flip.h"

namespace voxcone {

namespace {

bool sameShape(const Image& a, const Image& b) {
    return a.width == b.width && a.height == b.height && a.channels == b.channels;
}

Image encoded(const Image& linear) {
    Image out = linear;
    for (float& v : out.data) v = srgbFromLinear(std::clamp(v, 0.0f, 1.0f));
    return out;
}

void requireFinite(const Image& image, const std::string& name) {
    for (std::size_t i = 0; i < image.data.size(); ++i) {
        if (std::isfinite(image.data[i])) continue;
        const auto channels = static_cast<std::size_t>(image.channels), width = static_cast<std::size_t>(image.width);
        const std::size_t pixel = i / channels;
        throw InputError(name, fmt::format("pixel ({}, {}) channel {}", pixel % width, pixel / width, i % channels),
                         std::isnan(image.data[i]) ? "is NaN" : "is infinite");
    }
}

/// Mean of 10·SSIM^1000 over the pixels that are not black in both pictures; 10 when none is left.
double thesisGrade(const Image& ssim, const Image& reference, const Image& test) {
    double total = 0;
    std::size_t counted = 0;
    const auto channels = static_cast<std::size_t>(ssim.channels);
    for (std::size_t i = 0; i < ssim.data.size(); i += channels) {
        bool black = true;
        for (std::size_t c = 0; c < channels; ++c) black = black && reference.data[i + c] <= 0 && test.data[i + c] <= 0;
        if (black) continue;
        for (std::size_t c = 0; c < channels; ++c)
            total += std::pow(std::max(static_cast<double>(ssim.data[i + c]), 0.0), 1000);
        counted += channels;
    }
    return counted == 0 ? 10 : 10 * total / static_cast<double>(counted);
}

}  // namespace

LinearError linearError(const Image& reference, const Image& test) {
    VOXCONE_CHECK(sameShape(reference, test) && !reference.data.empty(), "{}x{} and {}x{}", reference.width,
                  reference.height, test.width, test.height);
    const auto n = static_cast<double>(reference.data.size());
    double squaredReference = 0, sumReference = 0, squaredError = 0, sumError = 0;
    std::vector<float> absolute(reference.data.size());
    for (std::size_t i = 0; i < reference.data.size(); ++i) {
        const double r = reference.data[i], e = static_cast<double>(test.data[i]) - r;
        squaredReference += r * r, sumReference += r, squaredError += e * e, sumError += e;
        absolute[i] = static_cast<float>(std::abs(e));
    }
    LinearError out;
    out.rmse = std::sqrt(squaredError / n);
    out.bias = sumError / n;
    out.relativeBias = sumError == 0 ? 0 : sumError / sumReference;
    out.epsilon = 0.01 * squaredReference / n;
    double relative = 0;
    for (std::size_t i = 0; i < reference.data.size(); ++i) {
        const double r = reference.data[i], e = static_cast<double>(test.data[i]) - r;
        if (e != 0) relative += e * e / (r * r + out.epsilon);
    }
    out.relMse = relative / n;
    const auto rank = static_cast<std::ptrdiff_t>(std::ceil(0.99 * n)) - 1;
    std::nth_element(absolute.begin(), absolute.begin() + rank, absolute.end());
    out.p99 = absolute[static_cast<std::size_t>(rank)];
    return out;
}

Image relativeErrorMap(const Image& reference, const Image& test) {
    VOXCONE_CHECK(sameShape(reference, test) && !reference.data.empty(), "{}x{} and {}x{}", reference.width,
                  reference.height, test.width, test.height);
    double squares = 0;
    for (const float v : reference.data) squares += static_cast<double>(v) * static_cast<double>(v);
    const double epsilon = 0.01 * squares / static_cast<double>(reference.data.size());
    Image out(reference.width, reference.height, 1);
    const auto channels = static_cast<std::size_t>(reference.channels);
    for (std::size_t i = 0; i < out.data.size(); ++i) {
        double sum = 0;
        for (std::size_t c = 0; c < channels; ++c) {
            const double r = reference.data[channels * i + c], e = static_cast<double>(test.data[channels * i + c]) - r;
            if (e != 0) sum += e / std::sqrt(r * r + epsilon);
        }
        out.data[i] = static_cast<float>(sum / reference.channels);
    }
    return out;
}

std::map<std::string, double> metricsByName(const LinearError& error) {
    return {{"relmse", error.relMse},
            {"rmse", error.rmse},
            {"bias", error.bias},
            {"relative_bias", error.relativeBias},
            {"p99", error.p99}};
}

std::map<std::string, double> metricsByName(const DisplayError& error) {
    return {{"flip", error.flip}, {"ssim", error.ssim}, {"psnr", error.psnr}, {"grade", error.grade}};
}

Image ssimMap(const Image& reference, const Image& test) {
    VOXCONE_CHECK(sameShape(reference, test), "{}x{} and {}x{}", reference.width, reference.height, test.width,
                  test.height);
    constexpr int kRadius = 5;
    constexpr double kSigma = 1.5, kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
    std::array<float, 2 * kRadius + 1> weight{};
    for (int i = -kRadius; i <= kRadius; ++i)
        weight[static_cast<std::size_t>(i + kRadius)] = static_cast<float>(std::exp(-i * i / (2 * kSigma * kSigma)));

    // Five windowed means at once: r, t, r², t², rt. Horizontal pass into `half`, vertical pass into the result. Means
    // are summed in double at the end only; differences of squares need the digits.
    const int w = reference.width, h = reference.height, channels = reference.channels;
    const auto pixels = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
    Image out(w, h, channels);
    std::vector<std::array<double, 5>> half(pixels);
    const auto index = [w](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x);
    };
    const auto window = [&](int centre, int size, auto&& add) {
        std::array<double, 5> mean{};
        double total = 0;
        for (int i = std::max(centre - kRadius, 0); i <= std::min(centre + kRadius, size - 1); ++i) {
            const double k = weight[static_cast<std::size_t>(i - centre + kRadius)];
            add(mean, i, k);
            total += k;
        }
        for (double& m : mean) m /= total;
        return mean;
    };
    for (int c = 0; c < channels; ++c) {
        tbb::parallel_for(tbb::blocked_range<int>(0, h, 8), [&](const tbb::blocked_range<int>& rows) {
            for (int y = rows.begin(); y < rows.end(); ++y) {
                for (int x = 0; x < w; ++x) {
                    half[index(x, y)] = window(x, w, [&](std::array<double, 5>& mean, int i, double k) {
                        const double r = reference.pixel(i, y)[c], t = test.pixel(i, y)[c];
                        mean[0] += k * r, mean[1] += k * t;
                        mean[2] += k * r * r, mean[3] += k * t * t, mean[4] += k * r * t;
                    });
                }
            }
        });
        tbb::parallel_for(tbb::blocked_range<int>(0, h, 8), [&](const tbb::blocked_range<int>& rows) {
            for (int y = rows.begin(); y < rows.end(); ++y) {
                for (int x = 0; x < w; ++x) {
                    const auto m = window(y, h, [&](std::array<double, 5>& mean, int i, double k) {
                        const std::array<double, 5>& row = half[index(x, i)];
                        for (std::size_t j = 0; j < 5; ++j) mean[j] += k * row[j];
                    });
                    const double varianceR = m[2] - m[0] * m[0], varianceT = m[3] - m[1] * m[1];
                    const double covariance = m[4] - m[0] * m[1];
                    out.pixel(x, y)[c] =
                        static_cast<float>((2 * m[0] * m[1] + kC1) * (2 * covariance + kC2) /
                                           ((m[0] * m[0] + m[1] * m[1] + kC1) * (varianceR + varianceT + kC2)));
                }
            }
        });
    }
    return out;
}

DisplayError displayError(const Image& reference, const Image& test) {
    const Image r = encoded(reference), t = encoded(test);
    double squared = 0;
    for (std::size_t i = 0; i < r.data.size(); ++i) {
        const double e = static_cast<double>(t.data[i]) - static_cast<double>(r.data[i]);
        squared += e * e;
    }
    DisplayError out;
    const double mse = squared / static_cast<double>(r.data.size());
    out.psnr = mse > 0 ? -10 * std::log10(mse) : std::numeric_limits<double>::infinity();
    const Image ssim = ssimMap(r, t);
    out.ssim = meanOf(ssim);
    out.grade = thesisGrade(ssim, r, t);
    out.flip = meanOf(flip(reference, test));
    return out;
}

void requireComparable(const Image& reference, const std::string& referenceName, const Image& test,
                       const std::string& testName) {
    if (reference.width != test.width || reference.height != test.height)
        throw InputError(testName, "",
                         fmt::format("is {}x{} pixels, the reference {} is {}x{}", test.width, test.height,
                                     referenceName, reference.width, reference.height));
    if (reference.channels != test.channels)
        throw InputError(
            testName, "",
            fmt::format("has {} channels, the reference {} has {}", test.channels, referenceName, reference.channels));
    requireFinite(reference, referenceName);
    requireFinite(test, testName);
}

}  // namespace voxcone
