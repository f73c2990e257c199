#include "metric/flip.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/check.h"

namespace voxcone {

namespace {

// One channel in row order; images are handled by planes so that filters vectorise.
struct Plane {
    int width = 0, height = 0;
    std::vector<float> values;
    Plane(int w, int h) : width(w), height(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
    float* row(int y) { return values.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width); }
    const float* row(int y) const {
        return values.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
    }
};
using Planes = std::array<Plane, 3>;

Planes planes(int width, int height) {
    return {Plane(width, height), Plane(width, height), Plane(width, height)};
}

template <class F>
void forRows(int height, F&& f) {
    tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& rows) {
        for (int y = rows.begin(); y < rows.end(); ++y) f(y);
    });
}

// ---- Colour (2020 paper, section 4.1): linear Rec. 709 -> XYZ -> YCxCz, and CIELab with Hunt's adjustment.

struct Color {
    float x, y, z;
};

constexpr float quotient(double a, double b) {
    return static_cast<float>(a / b);
}
constexpr float kRgbToXyz[3][3] = {
    {quotient(10135552, 24577794), quotient(8788810, 24577794), quotient(4435075, 24577794)},
    {quotient(2613072, 12288897), quotient(8788810, 12288897), quotient(887015, 12288897)},
    {quotient(1425312, 73733382), quotient(8788810, 73733382), quotient(70074185, 73733382)}};
constexpr float kXyzToRgb[3][3] = {{3.241003275f, -1.537398934f, -0.498615861f},
                                   {-0.969224334f, 1.875930071f, 0.041554224f},
                                   {0.055639423f, -0.204011202f, 1.057148933f}};
// XYZ of linear white (1,1,1).
constexpr Color kWhite = {kRgbToXyz[0][0] + kRgbToXyz[0][1] + kRgbToXyz[0][2],
                          kRgbToXyz[1][0] + kRgbToXyz[1][1] + kRgbToXyz[1][2],
                          kRgbToXyz[2][0] + kRgbToXyz[2][1] + kRgbToXyz[2][2]};

Color multiply(const float (&m)[3][3], const Color& c) {
    return {m[0][0] * c.x + m[0][1] * c.y + m[0][2] * c.z, m[1][0] * c.x + m[1][1] * c.y + m[1][2] * c.z,
            m[2][0] * c.x + m[2][1] * c.y + m[2][2] * c.z};
}

/// XYZ over the white's XYZ.
Color relativeXyz(const Color& rgb) {
    const Color xyz = multiply(kRgbToXyz, rgb);
    return {xyz.x / kWhite.x, xyz.y / kWhite.y, xyz.z / kWhite.z};
}

Color ycxczFromRgb(const Color& rgb) {
    const Color r = relativeXyz(rgb);
    return {116 * r.y - 16, 500 * (r.x - r.y), 200 * (r.y - r.z)};
}

Color rgbFromYcxcz(const Color& c) {
    const float y = (c.x + 16) / 116, x = y + c.y / 500, z = y - c.z / 200;
    return multiply(kXyzToRgb, {x * kWhite.x, y * kWhite.y, z * kWhite.z});
}

Color huntLabFromRgb(const Color& rgb) {
    const auto f = [](float t) {
        constexpr float delta = 6.0f / 29;
        return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0f / 29;
    };
    const Color r = relativeXyz(rgb);
    const float fx = f(r.x), fy = f(r.y), fz = f(r.z);
    const float l = 116 * fy - 16;
    return {l, 0.01f * l * 500 * (fx - fy), 0.01f * l * 200 * (fy - fz)};
}

float hyab(const Color& a, const Color& b) {
    return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

// ---- Filters. All are separable and hold the border pixels beyond the border.

using Kernel = std::vector<float>;  // 2r+1 taps

/// `in` filtered by `horizontal` and `vertical`, which have the same radius.
Plane filter(const Plane& in, const Kernel& horizontal, const Kernel& vertical) {
    const int radius = static_cast<int>(horizontal.size() / 2), w = in.width, h = in.height;
    Plane half(w, h), out(w, h);
    forRows(h, [&](int y) {
        std::vector<float> padded(static_cast<std::size_t>(w + 2 * radius));
        const float* source = in.row(y);
        for (int x = -radius; x < w + radius; ++x)
            padded[static_cast<std::size_t>(x + radius)] = source[std::clamp(x, 0, w - 1)];
        float* target = half.row(y);
        for (std::size_t k = 0; k < horizontal.size(); ++k) {
            const float weight = horizontal[k];
            const float* shifted = padded.data() + k;
            for (int x = 0; x < w; ++x) target[x] += weight * shifted[x];
        }
    });
    forRows(h, [&](int y) {
        float* target = out.row(y);
        for (std::size_t k = 0; k < vertical.size(); ++k) {
            const float weight = vertical[k];
            const float* source = half.row(std::clamp(y + static_cast<int>(k) - radius, 0, h - 1));
            for (int x = 0; x < w; ++x) target[x] += weight * source[x];
        }
    });
    return out;
}

/// Contrast sensitivity of one channel as a sum of Gaussians (2020 paper, table 1): a·√(π/b)·exp(−π²d²/b), d in
/// degrees.
struct Sensitivity {
    double a1, b1, a2, b2;
};
constexpr Sensitivity kAchromatic = {1, 0.0047, 0, 1e-5}, kRedGreen = {1, 0.0053, 0, 1e-5},
                      kBlueYellow = {34.1, 0.04, 13.5, 0.025};

double sum(const Kernel& kernel) {
    return std::accumulate(kernel.begin(), kernel.end(), 0.0);
}

Kernel gaussian(int radius, double (*exponent)(double, double), double parameter, double step) {
    Kernel kernel;
    for (int i = -radius; i <= radius; ++i)
        kernel.push_back(static_cast<float>(std::exp(exponent(i * step, parameter))));
    return kernel;
}

/// The eye's blur of one channel. The two-dimensional kernel is normalised as a whole.
Plane blur(const Plane& in, const Sensitivity& s, double pixelsPerDegree) {
    using std::numbers::pi;
    const double widest = kBlueYellow.b1;
    const int radius = static_cast<int>(std::ceil(3 * std::sqrt(widest / (2 * pi * pi)) * pixelsPerDegree));
    const auto exponent = [](double d, double b) { return -std::numbers::pi * std::numbers::pi * d * d / b; };
    Kernel first = gaussian(radius, exponent, s.b1, 1 / pixelsPerDegree);
    Kernel second = gaussian(radius, exponent, s.b2, 1 / pixelsPerDegree);
    const double amount1 = s.a1 * std::sqrt(pi / s.b1) * sum(first) * sum(first);
    const double amount2 = s.a2 * std::sqrt(pi / s.b2) * sum(second) * sum(second);
    const auto scaled = [](Kernel kernel, double scale) {
        for (float& tap : kernel) tap = static_cast<float>(tap * scale);
        return kernel;
    };
    const Kernel unit1 = scaled(first, 1 / sum(first));
    Plane out = filter(in, scaled(unit1, amount1 / (amount1 + amount2)), unit1);
    if (amount2 > 0) {
        const Kernel unit2 = scaled(second, 1 / sum(second));
        const Plane more = filter(in, scaled(unit2, amount2 / (amount1 + amount2)), unit2);
        for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] += more.values[i];
    }
    return out;
}

/// Kernels of the feature detectors (2020 paper, section 4.2): a Gaussian, its first and its second derivative. The
/// positive and the negative taps of the derivatives each sum to ±1.
struct FeatureKernels {
    Kernel smooth, edge, point;
};

FeatureKernels featureKernels(double pixelsPerDegree) {
    constexpr double kWidth = 0.082;  // degrees, the detector's extent
    const double sigma = 0.5 * kWidth * pixelsPerDegree;
    const int radius = static_cast<int>(std::ceil(3 * sigma));
    FeatureKernels kernels;
    for (int i = -radius; i <= radius; ++i) {
        const double g = std::exp(-i * i / (2 * sigma * sigma));
        kernels.smooth.push_back(static_cast<float>(g));
        kernels.edge.push_back(static_cast<float>(-i * g));
        kernels.point.push_back(static_cast<float>((i * i / (sigma * sigma) - 1) * g));
    }
    const auto normalise = [](Kernel& kernel) {
        double positive = 0, negative = 0;
        for (const float tap : kernel) (tap > 0 ? positive : negative) += tap;
        for (float& tap : kernel) tap = static_cast<float>(tap / (tap > 0 ? positive : std::max(-negative, 1e-30)));
    };
    normalise(kernels.smooth), normalise(kernels.edge), normalise(kernels.point);
    return kernels;
}

/// What one picture gives: its blurred colours in Hunt-adjusted CIELab and its feature strengths.
struct Seen {
    Planes lab;
    Plane edge, point;
};

Seen see(const Planes& rgb, double pixelsPerDegree) {
    const int w = rgb[0].width, h = rgb[0].height;
    Planes opponent = planes(w, h);
    Plane luma(w, h);
    forRows(h, [&](int y) {
        for (int x = 0; x < w; ++x) {
            const Color c = ycxczFromRgb({rgb[0].row(y)[x], rgb[1].row(y)[x], rgb[2].row(y)[x]});
            opponent[0].row(y)[x] = c.x, opponent[1].row(y)[x] = c.y, opponent[2].row(y)[x] = c.z;
            luma.row(y)[x] = (c.x + 16) / 116;
        }
    });
    const Planes blurred = {blur(opponent[0], kAchromatic, pixelsPerDegree),
                            blur(opponent[1], kRedGreen, pixelsPerDegree),
                            blur(opponent[2], kBlueYellow, pixelsPerDegree)};
    const FeatureKernels k = featureKernels(pixelsPerDegree);
    const Plane edgeX = filter(luma, k.edge, k.smooth), edgeY = filter(luma, k.smooth, k.edge);
    const Plane pointX = filter(luma, k.point, k.smooth), pointY = filter(luma, k.smooth, k.point);

    Seen seen{std::move(opponent), Plane(w, h), Plane(w, h)};
    forRows(h, [&](int y) {
        for (int x = 0; x < w; ++x) {
            const Color c = rgbFromYcxcz({blurred[0].row(y)[x], blurred[1].row(y)[x], blurred[2].row(y)[x]});
            const auto clipped = [](float v) { return std::clamp(v, 0.0f, 1.0f); };
            const Color lab = huntLabFromRgb({clipped(c.x), clipped(c.y), clipped(c.z)});
            seen.lab[0].row(y)[x] = lab.x, seen.lab[1].row(y)[x] = lab.y, seen.lab[2].row(y)[x] = lab.z;
            const auto length = [](float a, float b) { return std::sqrt(a * a + b * b); };
            seen.edge.row(y)[x] = length(edgeX.row(y)[x], edgeY.row(y)[x]);
            seen.point.row(y)[x] = length(pointX.row(y)[x], pointY.row(y)[x]);
        }
    });
    return seen;
}

/// Per-pixel error of two pictures with values in [0,1].
Plane flipOfPlanes(const Planes& reference, const Planes& test, double pixelsPerDegree) {
    // Constants of the 2020 paper, sections 4.1 and 4.2.
    constexpr float qc = 0.7f, pc = 0.4f, pt = 0.95f, qf = 0.5f;
    const float largest = std::pow(hyab(huntLabFromRgb({0, 1, 0}), huntLabFromRgb({0, 0, 1})), qc);
    const Seen r = see(reference, pixelsPerDegree), t = see(test, pixelsPerDegree);
    Plane error(reference[0].width, reference[0].height);
    forRows(error.height, [&](int y) {
        for (int x = 0; x < error.width; ++x) {
            const auto at = [&](const Planes& lab) {
                return Color{lab[0].row(y)[x], lab[1].row(y)[x], lab[2].row(y)[x]};
            };
            const float power = std::pow(hyab(at(r.lab), at(t.lab)), qc);
            const float knee = pc * largest;
            const float color = power < knee ? pt / knee * power : pt + (power - knee) / (largest - knee) * (1 - pt);
            const float difference = std::max(std::abs(r.edge.row(y)[x] - t.edge.row(y)[x]),
                                              std::abs(r.point.row(y)[x] - t.point.row(y)[x]));
            const float feature = std::pow(difference / std::numbers::sqrt2_v<float>, qf);
            error.row(y)[x] = std::pow(std::clamp(color, 0.0f, 1.0f), 1 - std::min(feature, 1.0f));
        }
    });
    return error;
}

template <class F>
Planes mapped(const Image& image, F&& f) {
    Planes out = planes(image.width, image.height);
    forRows(image.height, [&](int y) {
        for (int x = 0; x < image.width; ++x) {
            const float* p = image.pixel(x, y);
            for (int c = 0; c < 3; ++c) out[static_cast<std::size_t>(c)].row(y)[x] = f(p[image.channels == 1 ? 0 : c]);
        }
    });
    return out;
}

Image imageOf(Plane&& plane) {
    Image image;
    image.width = plane.width, image.height = plane.height, image.channels = 1;
    image.data = std::move(plane.values);
    return image;
}

void checkArguments(const Image& reference, const Image& test) {
    VOXCONE_CHECK(
        reference.width == test.width && reference.height == test.height && reference.channels == test.channels,
        "{}x{}x{} and {}x{}x{}", reference.width, reference.height, reference.channels, test.width, test.height,
        test.channels);
    VOXCONE_CHECK(reference.channels == 1 || reference.channels == 3, "{} channels", reference.channels);
}

/// ACES fit of K. Narkowicz with the pre-exposure of 0.6 taken out, as the 2021 paper has it: (k0x²+k1x)/(k3x²+k4x+k5).
constexpr double kAces[6] = {0.6 * 0.6 * 2.51, 0.6 * 0.03, 0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14};

float aces(float x) {
    const auto k = [](int i) { return static_cast<float>(kAces[i]); };
    return std::clamp((k(0) * x * x + k(1) * x + k(2)) / (k(3) * x * x + k(4) * x + k(5)), 0.0f, 1.0f);
}

/// The value that the tone curve brings to 0.85, where the 2021 paper takes a highlight (section 4) to begin.
double acesHighlight() {
    constexpr double t = 0.85;
    const double a = kAces[0] - t * kAces[3], b = kAces[1] - t * kAces[4], c = kAces[2] - t * kAces[5];
    return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
}

}  // namespace

Image flip(const Image& reference, const Image& test, double pixelsPerDegree) {
    checkArguments(reference, test);
    const auto clipped = [](float v) { return std::clamp(v, 0.0f, 1.0f); };
    return imageOf(flipOfPlanes(mapped(reference, clipped), mapped(test, clipped), pixelsPerDegree));
}

HdrFlip hdrFlip(const Image& reference, const Image& test, double pixelsPerDegree) {
    checkArguments(reference, test);
    std::vector<float> luminance;  // of the pixels that are not black
    for (int y = 0; y < reference.height; ++y) {
        for (int x = 0; x < reference.width; ++x) {
            const float* p = reference.pixel(x, y);
            const float value = reference.channels == 1 ? p[0] : 0.2126f * p[0] + 0.7152f * p[1] + 0.0722f * p[2];
            if (value > 0) luminance.push_back(value);
        }
    }

    // From the exposure at which the brightest pixel is a highlight to that at which the median is. Unlike the paper's,
    // the median leaves black pixels out: a background would ask for an endless range.
    HdrFlip result;
    if (!luminance.empty()) {
        const float brightest = *std::max_element(luminance.begin(), luminance.end());
        const auto middle = luminance.begin() + static_cast<std::ptrdiff_t>(luminance.size() / 2);
        std::nth_element(luminance.begin(), middle, luminance.end());
        const double lowest = std::max(static_cast<double>(*middle), std::ldexp(static_cast<double>(brightest), -16));
        result.startExposure = std::log2(acesHighlight() / static_cast<double>(brightest));
        result.stopExposure = std::log2(acesHighlight() / lowest);
    }
    result.exposures = std::max(2, static_cast<int>(std::ceil(result.stopExposure - result.startExposure)));
    result.error = Image(reference.width, reference.height, 1);
    for (int i = 0; i < result.exposures; ++i) {
        const double stops =
            result.startExposure + i * (result.stopExposure - result.startExposure) / (result.exposures - 1);
        const auto scale = static_cast<float>(std::exp2(stops));
        const auto shown = [scale](float v) { return aces(scale * std::max(v, 0.0f)); };
        const Plane error = flipOfPlanes(mapped(reference, shown), mapped(test, shown), pixelsPerDegree);
        for (std::size_t p = 0; p < error.values.size(); ++p)
            result.error.data[p] = std::max(result.error.data[p], error.values[p]);
    }
    return result;
}

double meanOf(const Image& image) {
    return std::accumulate(image.data.begin(), image.data.end(), 0.0) /
           static_cast<double>(std::max<std::size_t>(image.data.size(), 1));
}

}  // namespace voxcone
