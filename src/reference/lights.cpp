#include "reference/lights.h"

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>

#include "scene/environment.h"
#include "scene/light_math.h"

namespace voxcone {
namespace {

constexpr float kPi = glm::pi<float>();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Points in a triangle at which a textured emission is averaged: only the choice of triangles depends on it.
constexpr int kEmissionSamples = 32;

// Cosine of the half-angle under which a sphere is seen, and 1 minus it without cancellation.
float oneMinusCosine(float sin2) {
    return sin2 / (1 + std::sqrt(std::max(0.0f, 1 - sin2)));
}

// Uniform over directions about +z whose 1 − cosine is at most `cap`.
glm::vec3 capDirection(float cap, const glm::vec2& u) {
    const float fromAxis = u.x * cap, phi = 2 * kPi * u.y;
    const float sine = std::sqrt(std::max(0.0f, fromAxis * (2 - fromAxis)));
    return {sine * std::cos(phi), sine * std::sin(phi), 1 - fromAxis};
}

// Uniform over a triangle: weights of its second and third vertex (Osada et al. 2002).
glm::vec2 trianglePoint(const glm::vec2& u) {
    const float s = std::sqrt(u.x);
    return {s * (1 - u.y), s * u.y};
}

}  // namespace

float luminance(const glm::vec3& rgb) {
    return glm::dot(rgb, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

glm::mat3 frameAround(const glm::vec3& n) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1 / (sign + n.z), b = n.x * n.y * a;
    return {glm::vec3(1 + sign * n.x * n.x * a, sign * b, -sign * n.x), glm::vec3(b, sign + n.y * n.y * a, -n.y), n};
}

glm::vec3 cosineDirection(const glm::vec2& u) {
    const float r = std::sqrt(u.x), phi = 2 * kPi * u.y;
    return {r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - u.x)};
}

AnalyticLights::AnalyticLights(const Scene& scene, double time, const TracingSpace& space) {
    const float lengthScale = static_cast<float>(space.scale);
    std::vector<double> power;
    double total = 0;
    for (const Light& light : scene.lightsAt(time)) {
        if (light.extracted) continue;
        PlacedLight p;
        p.type = light.type;
        p.radiance = light.intensity;
        p.position = space.fromWorld(light.position);
        p.direction = glm::vec3(glm::normalize(light.direction));
        p.range = static_cast<float>(light.range * space.scale);
        double watts = luminance(light.intensity);
        switch (light.type) {
            case LightType::directional:
                watts *= glm::pi<double>();  // over a disc as large as the scene
                if (light.angularRadius <= 0) break;
                p.radius = static_cast<float>(std::sin(light.angularRadius));
                p.radiance /= static_cast<float>(glm::pi<double>() * std::pow(std::sin(light.angularRadius), 2));
                break;
            case LightType::spot:
                p.cosInner = static_cast<float>(std::cos(light.innerConeAngle));
                p.cosOuter = static_cast<float>(std::cos(light.outerConeAngle));
                p.radiance *= lengthScale * lengthScale;
                watts *= 2 * glm::pi<double>() * (1 - static_cast<double>(p.cosOuter)) * space.scale * space.scale;
                break;
            case LightType::rectangle: {
                const glm::dvec3 along = glm::normalize(light.direction);
                p.up = glm::vec3(glm::normalize(light.up - along * glm::dot(along, light.up)));
                p.right = glm::cross(p.direction, p.up);
                p.halfWidth = static_cast<float>(0.5 * light.width * space.scale);
                p.halfHeight = static_cast<float>(0.5 * light.height * space.scale);
                watts *= glm::pi<double>() * light.width * light.height * space.scale * space.scale;
                break;
            }
            case LightType::sphere:
                p.radius = static_cast<float>(light.radius * space.scale);
                if (p.radius > 0)
                    p.radiance = light.intensity / static_cast<float>(glm::pi<double>() * light.radius * light.radius);
                [[fallthrough]];
            case LightType::point:
                if (p.radius <= 0) {
                    p.type = LightType::point;
                    p.radiance *= lengthScale * lengthScale;
                }
                watts *= 4 * glm::pi<double>() * space.scale * space.scale;
                break;
        }
        if (!(watts > 0)) continue;
        if (p.type == LightType::rectangle || p.radius > 0) areaLights_.push_back(lights_.size());
        lights_.push_back(p);
        power.push_back(watts);
        total += watts;
    }
    // A near dim light may matter more than a far strong one: a tenth of the choices ignores power.
    for (double& watts : power) watts = 0.9 * watts / total + 0.1 / static_cast<double>(power.size());
    choice_ = Distribution(power);
}

bool AnalyticLights::hit(const PlacedLight& light, const glm::vec3& origin, const glm::vec3& direction, float& distance,
                         float& pdf) {
    const glm::vec3 toCenter = light.position - origin;
    if (light.type == LightType::rectangle) {
        const float facing = -glm::dot(direction, light.direction), height = -glm::dot(toCenter, light.direction);
        if (facing <= 0 || height <= 0) return false;
        distance = height / facing;
        const glm::vec3 p = distance * direction - toCenter;
        if (std::abs(glm::dot(p, light.right)) > light.halfWidth || std::abs(glm::dot(p, light.up)) > light.halfHeight)
            return false;
        pdf = distance * distance / (facing * 4 * light.halfWidth * light.halfHeight);
        return true;
    }
    if (light.type == LightType::directional) {
        // |a − b|² of unit vectors is 2(1 − cosine), without cancellation.
        const glm::vec3 apart = direction + light.direction;
        const float cap = oneMinusCosine(light.radius * light.radius);
        if (glm::dot(apart, apart) > 2 * cap) return false;
        distance = std::numeric_limits<float>::max();
        pdf = 1 / (2 * kPi * cap);
        return true;
    }
    const float d2 = glm::dot(toCenter, toCenter), r2 = light.radius * light.radius;
    if (d2 <= r2) return false;  // inside nothing shines
    const float along = glm::dot(toCenter, direction);
    const glm::vec3 across = toCenter - along * direction;
    const float miss2 = glm::dot(across, across);
    if (along <= 0 || miss2 > r2) return false;
    distance = along - std::sqrt(r2 - miss2);
    pdf = 1 / (2 * kPi * oneMinusCosine(r2 / d2));
    return true;
}

LightSample AnalyticLights::sample(const glm::vec3& origin, const glm::vec2& u, float uChoice) const {
    LightSample sample;
    const std::size_t k = choice_.sample(uChoice);
    const PlacedLight& light = lights_[k];
    const float chosen = choice_.probability(k);
    const glm::vec3 toCenter = light.position - origin;
    switch (light.type) {
        case LightType::directional:
            sample.direction = -light.direction;
            sample.toTarget = sample.direction;
            sample.far = kInfinity;
            sample.radiance = light.radiance;
            sample.pdf = chosen;
            sample.delta = light.radius <= 0;
            if (sample.delta) break;
            {
                const float cap = oneMinusCosine(light.radius * light.radius);
                sample.direction = frameAround(-light.direction) * capDirection(cap, u);
                sample.toTarget = sample.direction;
                sample.pdf = chosen / (2 * kPi * cap);
            }
            break;
        case LightType::point:
        case LightType::spot: {
            const float d2 = glm::dot(toCenter, toCenter);
            if (!(d2 > 0)) break;
            const float distance = std::sqrt(d2);
            sample.direction = toCenter / distance;
            sample.toTarget = toCenter;
            sample.far = 1 - kLightClearance;
            sample.radiance = light.radiance * (rangeWindow(distance, light.range) / d2);
            if (light.type == LightType::spot)
                sample.radiance *=
                    spotFalloff(-glm::dot(sample.direction, light.direction), light.cosInner, light.cosOuter);
            sample.pdf = chosen;
            sample.delta = true;
            break;
        }
        case LightType::sphere: {
            const float d2 = glm::dot(toCenter, toCenter), r2 = light.radius * light.radius;
            if (d2 <= r2) break;
            const float cap = oneMinusCosine(r2 / d2), d = std::sqrt(d2);
            const glm::vec3 local = capDirection(cap, u);
            sample.direction = frameAround(toCenter / d) * local;
            const float reach =
                d * local.z - std::sqrt(std::max(0.0f, r2 - d2 * (local.x * local.x + local.y * local.y)));
            sample.toTarget = sample.direction * reach;
            sample.far = 1 - kLightClearance;
            sample.radiance = light.radiance;
            sample.pdf = chosen / (2 * kPi * cap);
            break;
        }
        case LightType::rectangle: {
            const glm::vec3 target =
                toCenter + (2 * u.x - 1) * light.halfWidth * light.right + (2 * u.y - 1) * light.halfHeight * light.up;
            const float d2 = glm::dot(target, target), distance = std::sqrt(d2);
            if (!(d2 > 0)) break;
            sample.direction = target / distance;
            const float facing = -glm::dot(sample.direction, light.direction);
            if (facing <= 0) break;
            sample.toTarget = target;
            sample.far = 1 - kLightClearance;
            sample.radiance = light.radiance;
            sample.pdf = chosen * d2 / (facing * 4 * light.halfWidth * light.halfHeight);
            break;
        }
    }
    return sample;
}

Emitters::Emitters(const Scene& scene, const Geometry& geometry)
    : geometry_(&geometry), environment_(&scene.environment) {
    std::vector<double> weights;
    pdfPerArea_.resize(geometry.instanceCount());
    for (std::uint32_t instance = 0; instance < geometry.instanceCount(); ++instance) {
        const Material& material = geometry.material(instance);
        if (!material.unlit && !material.emits()) continue;
        const std::size_t count = geometry.triangleCount(instance);
        pdfPerArea_[instance].assign(count, 0);
        for (std::uint32_t triangle = 0; triangle < count; ++triangle) {
            const float area = geometry.area(instance, triangle);
            double mean = 0;
            for (int k = 0; k < kEmissionSamples; ++k) {
                // The R2 sequence (Roberts 2018), which covers the square evenly for any count.
                const double n = k + 0.5;
                const glm::vec2 p =
                    trianglePoint(glm::vec2(glm::fract(n * 0.7548776662466927), glm::fract(n * 0.5698402909980532)));
                const Hit hit = geometry.pointOn(instance, triangle, p.x, p.y);
                const Shading shading = geometry.shade(hit, hit.normal);
                mean += static_cast<double>(shading.coverage * luminance(shading.emission)) / kEmissionSamples;
            }
            const double weight = mean * static_cast<double>(area);
            if (!(weight > 0)) continue;
            triangles_.push_back({instance, triangle});
            weights.push_back(weight);
        }
    }
    triangleChoice_ = Distribution(weights);
    for (std::size_t k = 0; k < triangles_.size(); ++k)
        pdfPerArea_[triangles_[k].instance][triangles_[k].triangle] =
            triangleChoice_.probability(k) / geometry.area(triangles_[k].instance, triangles_[k].triangle);

    const Environment& sky = scene.environment;
    if (!sky.radiance.empty() && !sky.black()) {
        std::vector<double> rowWeights;
        std::vector<double> row(static_cast<std::size_t>(sky.width));
        for (int y = 0; y < sky.height; ++y) {
            const double sine = std::sin(glm::pi<double>() * (y + 0.5) / sky.height);
            double sum = 0;
            for (int x = 0; x < sky.width; ++x) {
                // Bilinear look-up spreads a texel over its neighbours, so the neighbours share its weight.
                double weight = 0;
                for (int dy = -1; dy <= 1; ++dy)
                    for (int dx = -1; dx <= 1; ++dx) {
                        const int ty = std::clamp(y + dy, 0, sky.height - 1), tx = (x + dx + sky.width) % sky.width;
                        const auto texel = static_cast<std::size_t>(ty) * static_cast<std::size_t>(sky.width) +
                                           static_cast<std::size_t>(tx);
                        weight += (dx == 0 ? 2 : 1) * (dy == 0 ? 2 : 1) *
                                  static_cast<double>(luminance(sky.color * sky.radiance[texel]));
                    }
                row[static_cast<std::size_t>(x)] = weight * sine;
                sum += weight * sine;
            }
            rowWeights.push_back(sum);
            columns_.emplace_back(row);
        }
        rows_ = Distribution(rowWeights);
    }
    triangleShare_ = triangleChoice_.empty() ? 0.0f : (rows_.empty() ? 1.0f : 0.5f);
    skyShare_ = rows_.empty() ? 0.0f : 1 - triangleShare_;
}

LightSample Emitters::sample(const glm::vec3& origin, const glm::vec2& u, float uChoice) const {
    if (uChoice < triangleShare_) return sampleTriangle(origin, u, uChoice / triangleShare_);
    return sampleSky(u);
}

LightSample Emitters::sampleTriangle(const glm::vec3& origin, const glm::vec2& u, float uChoice) const {
    LightSample sample;
    const std::size_t k = triangleChoice_.sample(uChoice);
    const Triangle& chosen = triangles_[k];
    const glm::vec2 p = trianglePoint(u);
    const Hit hit = geometry_->pointOn(chosen.instance, chosen.triangle, p.x, p.y);
    const glm::vec3 exact = hit.position - origin;
    const float height = -glm::dot(exact, hit.normal);
    // Just before the triangle, on the side the receiver is on, farther than the end of the shadow ray is in error.
    const float clearance = hit.offset + Geometry::offset(exact, hit.normal, glm::abs(origin) + glm::abs(exact));
    const glm::vec3 target = exact + std::copysign(clearance, height) * hit.normal;
    const float d2 = glm::dot(target, target);
    if (!(d2 > 0)) return sample;
    sample.direction = target / std::sqrt(d2);
    sample.toTarget = target;
    sample.far = 1;
    const Shading shading = geometry_->shade(hit, -sample.direction);
    sample.radiance = shading.coverage * shading.emission;
    sample.directShare = directShare(hit);
    const float facing = std::abs(glm::dot(sample.direction, hit.normal));
    if (facing > 0)
        sample.pdf = triangleShare_ * pdfPerArea_[chosen.instance][chosen.triangle] * glm::dot(exact, exact) / facing;
    return sample;
}

LightSample Emitters::sampleSky(glm::vec2 u) const {
    const std::size_t row = rows_.sample(u.y), column = columns_[row].sample(u.x);
    const float longitude =
        2 * kPi * ((static_cast<float>(column) + u.x) / static_cast<float>(environment_->width) - 0.5f) -
        static_cast<float>(glm::radians(environment_->rotationDeg));
    const float polar = kPi * (static_cast<float>(row) + u.y) / static_cast<float>(environment_->height);
    LightSample sample;
    sample.direction = {std::sin(polar) * std::sin(longitude), std::cos(polar), -std::sin(polar) * std::cos(longitude)};
    sample.toTarget = sample.direction;
    sample.far = kInfinity;
    sample.radiance = sky(sample.direction);
    sample.pdf = pdfOfSky(sample.direction);
    sample.directShare = directShareOfSky(sample.direction);
    return sample;
}

float Emitters::pdfOfHit(const Hit& hit, const glm::vec3& direction) const {
    const std::vector<float>& densities = pdfPerArea_[hit.instance];
    if (densities.empty()) return 0;
    const float facing = std::abs(glm::dot(direction, hit.normal));
    return facing > 0 ? triangleShare_ * densities[hit.triangle] * hit.distance * hit.distance / facing : 0;
}

float Emitters::pdfOfSky(const glm::vec3& direction) const {
    if (skyShare_ == 0) return 0;
    const glm::vec2 uv = environmentUv(*environment_, direction);
    const auto row = static_cast<std::size_t>(
        std::min(static_cast<int>(uv.y * static_cast<float>(environment_->height)), environment_->height - 1));
    const auto column = static_cast<std::size_t>(
        std::min(static_cast<int>(uv.x * static_cast<float>(environment_->width)), environment_->width - 1));
    const float sine = std::sqrt(std::max(0.0f, direction.x * direction.x + direction.z * direction.z));
    if (sine <= 0 || columns_[row].empty()) return 0;
    const float perUv = rows_.probability(row) * columns_[row].probability(column) *
                        static_cast<float>(environment_->width) * static_cast<float>(environment_->height);
    return skyShare_ * perUv / (2 * kPi * kPi * sine);
}

glm::vec3 Emitters::directShareOfSky(const glm::vec3& direction) const {
    if (environment_->residual.empty()) return glm::vec3(0);
    const glm::vec3 all = sky(direction), left = environmentResidual(*environment_, direction);
    glm::vec3 share(0);
    for (int c = 0; c < 3; ++c)
        if (all[c] > 0) share[c] = glm::clamp(1 - left[c] / all[c], 0.0f, 1.0f);
    return share;
}

glm::vec3 Emitters::sky(const glm::vec3& direction) const {
    return environmentRadiance(*environment_, direction);
}

}  // namespace voxcone
