// Light from analytic lights: the records of src/light/light_layout.h, exact irradiance without shadows, shadows from the
// depth atlas, and both together for a Lambert receiver (directIrradiance) or a full surface (directLight).
// Positions are relative to the scene's origin.
#ifndef VOXCONE_LIGHTS_GLSL
#define VOXCONE_LIGHTS_GLSL

#include "shared/brdf.glsl"
#include "shared/light_math.glsl"
#include "light/shadow_view.glsl"

// Twins in src/light/shadow_maps.h.
#define LIGHT_STORAGE 2
#define SHADOW_DEPTH_UNIT 15

#define LIGHT_DIRECTIONAL 0u
#define LIGHT_POINT 1u
#define LIGHT_SPOT 2u
#define LIGHT_SPHERE 3u
#define LIGHT_RECTANGLE 4u

struct Light {
    vec3 position;
    uint type;
    vec3 direction;
    float range;
    vec3 intensity;
    float radius;  // sine of the angular radius of a directional light
    vec3 right;
    float halfWidth;
    vec3 up;
    float halfHeight;
    float cosInnerCone, cosOuterCone;
    float stratumSize;
    uint padding0;
    uint firstView, faces, samples;
    uint padding1;
};
layout(std430, binding = LIGHT_STORAGE) readonly buffer Lights { Light b_lights[]; };

uniform int u_lightCount;
layout(binding = SHADOW_DEPTH_UNIT) uniform sampler2D u_shadowDepth;

const float kPi = 3.14159265358979;

// ---------------------------------------------------------------------------------------------------- without shadows

// Form factor of a sphere whose centre is at `toCenter`, cut by the horizon of unit normal n, over radius²
// (docs/accuracy.md, rows B5 and B6: irradiance = π L F, and L = intensity / (π radius²), so irradiance =
// intensity · F/radius²).
float sphereFormFactorOverRadius2(vec3 toCenter, vec3 n, float radius) {
    float d2 = dot(toCenter, toCenter), r2 = radius * radius;
    float c = dot(n, toCenter) * inversesqrt(d2);
    float h2 = d2 / r2;
    if (h2 <= 1.0) return 0.0;  // inside nothing shines
    float k = 1.0 - h2 * c * c;
    if (k <= 0.0) return max(c, 0.0) / (h2 * r2);
    float q = h2 - 1.0;
    float s = sqrt(max(1.0 - c * c, 1e-12));
    float F = (c * acos(clamp(-c * sqrt(q) / s, -1.0, 1.0)) - sqrt(k * q)) / h2 + atan(sqrt(k / q));
    return max(F, 0.0) / (kPi * r2);
}

// Irradiance by a disc of the sky that the horizon cuts, over that on a facing plane. `cosine`: of its middle, `radius`: the
// sine of its angular radius.
float discOnHorizon(float cosine, float radius) {
    if (radius > 0.1) return sphereFormFactorOverRadius2(vec3(sqrt(1.0 - cosine * cosine), cosine, 0.0), vec3(0.0, 1.0, 0.0), radius);
    // As a flat disc, to radius²/3 of it: the above would lose its digits.
    float t = cosine / radius, s = sqrt(1.0 - t * t);
    return radius * (t * (0.5 + (t * s + asin(t)) / kPi) + 2.0 / (3.0 * kPi) * s * s * s);
}

// One edge of Lambert's polygon formula: angle between a and b times the cosine of the normal of their plane.
float edgeIntegral(vec3 a, vec3 b, vec3 n) {
    vec3 product = cross(normalize(a), normalize(b));
    float sine = length(product);
    return sine > 0.0 ? atan(sine, dot(normalize(a), normalize(b))) * dot(n, product) / sine : 0.0;
}

// Form factor of a rectangle seen from the origin, cut by the horizon of unit normal n (docs/accuracy.md, row C3).
// One-sided: light travels along `direction`.
float rectangleFormFactor(vec3 center, vec3 direction, vec3 halfRight, vec3 halfUp, vec3 n) {
    if (dot(center, direction) >= 0.0) return 0.0;
    vec3 corners[4] = vec3[4](center - halfRight - halfUp, center + halfRight - halfUp, center + halfRight + halfUp,
                              center - halfRight + halfUp);
    float sum = 0.0;
    // A convex polygon leaves the upper half space once and comes back once: the cut closes it along the horizon (as does
    // an edge that lies in it, which is skipped below).
    vec3 leaving = vec3(0.0), entering = vec3(0.0);
    bool cut = false;
    for (int i = 0; i < 4; ++i) {
        vec3 a = corners[i], b = corners[(i + 1) & 3];
        float ha = dot(a, n), hb = dot(b, n);
        if (ha <= 0.0 && hb <= 0.0) continue;
        if (ha <= 0.0) {
            a += (b - a) * (ha / (ha - hb));
            entering = a;
            cut = true;
        } else if (hb <= 0.0) {
            b = a + (b - a) * (ha / (ha - hb));
            leaving = b;
            cut = true;
        }
        sum += edgeIntegral(a, b, n);
    }
    if (cut) sum += edgeIntegral(leaving, entering, n);
    // Either orientation of the corners may face the receiver.
    return abs(sum) / (2.0 * kPi);
}

// Irradiance at `pos` on a plane of unit normal n, nothing in between.
vec3 unshadowedIrradiance(Light light, vec3 pos, vec3 n) {
    if (light.type == LIGHT_DIRECTIONAL) {
        float cosine = -dot(light.direction, n);
        if (abs(cosine) < light.radius) cosine = discOnHorizon(cosine, light.radius);
        return light.intensity * max(cosine, 0.0);
    }
    vec3 toLight = light.position - pos;
    if (light.type == LIGHT_SPHERE) {
        return light.intensity * sphereFormFactorOverRadius2(toLight, n, light.radius);
    }
    if (light.type == LIGHT_RECTANGLE) {
        return light.intensity * (kPi * rectangleFormFactor(toLight, light.direction, light.right * light.halfWidth,
                                                            light.up * light.halfHeight, n));
    }
    float d2 = dot(toLight, toLight), d = sqrt(d2);
    float height = dot(toLight, n);
    if (height <= 0.0) return vec3(0.0);
    float factor = height / (d2 * d) * rangeWindow(d, light.range);
    if (light.type == LIGHT_SPOT) {
        factor *= spotFalloff(-dot(light.direction, toLight) / d, light.cosInnerCone, light.cosOuterCone);
    }
    return light.intensity * factor;
}

// -------------------------------------------------------------------------------------------------------------- shadows

// Depth along the view of the plane through a receiver (n·x = c, in the view's frame) at plane coordinate t.
// Nothing behind the receiver's own depth `most` can be between it and the light, so that is the bound; it is also the
// answer where the plane is never met.
float planeDepth(ShadowView view, vec3 n, float c, vec2 t, float most) {
    float along = dot(n.xy, t);
    float z = view.perspective > 0.0 ? (along + n.z < 0.0 ? c / (along + n.z) : most) : (c - along) / min(n.z, -1e-6);
    return min(z, most);
}

float windowDepth(ShadowView view, float z) {
    float depth = view.perspective > 0.0 ? view.depth.x - view.depth.y / z : view.depth.x + view.depth.y * z;
    return clamp(depth, 0.0, 1.0);
}

// A receiver as a view sees it.
struct ShadowReceiver {
    vec3 n;        // normal, in the view's frame
    float lifted;  // n·x = lifted is its tangent plane, lifted towards the light
    float most;    // its own depth along the view on that plane
};

// The four texels around plane coordinate t, of which a bilinear look-up would make its answer.
struct ShadowTexels {
    vec4 depths;   // window depths
    vec4 weights;  // bilinear, sum 1
    vec4 blocked;  // 1 where the texel is before the receiver's plane at its own centre
};

ShadowTexels lookUp(ShadowView view, ShadowReceiver receiver, vec2 t) {
    vec2 size = vec2(textureSize(u_shadowDepth, 0));
    vec2 place = (view.tileCenter + t * view.scale * view.tileHalfSize) * size - 0.5;
    vec2 corner = floor(place), f = place - corner;
    ShadowTexels texels;
    // Where the four meet, so that rounding cannot choose others.
    texels.depths = textureGather(u_shadowDepth, (corner + 1.0) / size);
    texels.weights = vec4((1.0 - f.x) * f.y, f.x * f.y, f.x * (1.0 - f.y), (1.0 - f.x) * (1.0 - f.y));
    vec2 low = t - f * view.texel, high = low + view.texel;
    vec4 limits = vec4(planeDepth(view, receiver.n, receiver.lifted, vec2(low.x, high.y), receiver.most),
                       planeDepth(view, receiver.n, receiver.lifted, high, receiver.most),
                       planeDepth(view, receiver.n, receiver.lifted, vec2(high.x, low.y), receiver.most),
                       planeDepth(view, receiver.n, receiver.lifted, low, receiver.most));
    for (int i = 0; i < 4; ++i) texels.blocked[i] = float(texels.depths[i] < windowDepth(view, limits[i]));
    return texels;
}

// Share of a light's sample point that `pos` sees, in [0,1]. normal: unit, geometric, on the light's side.
// `slack`: uncertainty of pos along the normal in metres (0 for exact positions).
//
// Bias: each texel of the filter is compared with the receiver's tangent plane at the texel's own centre, where a plane
// that is its own occluder has exactly the depth that was stored. So no slope of the plane has to be allowed for, and the
// plane is lifted along n by only kShadowLift texels (their width at the receiver), for the rounding of depths and for
// curved surfaces, whose other triangles stand above the plane. Being measured along the normal the lift never grows at
// grazing angles; only the depth is lifted, not the place of the look-up, so shadow edges do not move. What stands within
// the lift above a surface that the light grazes at the angle θ throws no shadow over lift/cosθ: that is why it is small.
// Everything is relative to texels: no scale of the scene enters.
const float kShadowLift = 0.5;

float sampleVisibility(Light light, ShadowView view, vec3 pos, vec3 normal, float slack) {
    vec3 n = vec3(dot(normal, view.right), dot(normal, view.up), dot(normal, view.forward));
    vec3 offset = pos - view.origin;
    vec3 p = vec3(dot(offset, view.right), dot(offset, view.up), dot(offset, view.forward));
    bool perspective = view.perspective > 0.0;
    if (perspective && p.z <= 0.0) return 1.0;
    vec2 t0 = perspective ? p.xy / p.z : p.xy;
    float footprint = perspective ? view.texel * p.z : view.texel;

    float c = dot(n, p);
    float lift = kShadowLift * footprint + slack;
    // The eye stays above the lifted plane.
    if (perspective) lift = min(lift, -0.5 * c);
    ShadowReceiver receiver;
    receiver.n = n;
    receiver.lifted = c + lift;
    receiver.most = perspective ? p.z * (receiver.lifted / min(c, -1e-30)) : p.z + lift / min(n.z, -1e-6);

    // The filter hides the stairs of one map; maps of several sample points also hide each other's.
    float kernel = view.filterRadius * inversesqrt(float(light.samples));
    int taps = 2;
    // What lies behind a rectangle's plane cannot shadow it: taps that look there, or touch texels that do, do not count.
    vec3 axis = vec3(0.0);
    float above = 0.0;
    if (light.type == LIGHT_RECTANGLE) {
        axis = vec3(dot(light.direction, view.right), dot(light.direction, view.up), dot(light.direction, view.forward));
        above = view.texel;
    }
    float stratum = light.stratumSize;
    if (stratum > 0.0) {
        // Percentage-closer soft shadows (Fernando 2005) for the stratum: where blockers are, on average, makes the width
        // of the penumbra (docs/accuracy.md, row K2). Blockers nearer to the light than a fifth of the way are searched too
        // narrowly.
        // Parallel views know the whole way; the search looks half as far to either side.
        float widest = perspective ? 4.0 * stratum / p.z : 2.0 * stratum * (p.z + view.depth.x / view.depth.y);
        float reach = max(min(widest / view.texel, view.maxKernel), kernel);
        float sum = 0.0, count = 0.0;
        for (int i = 0; i < 4; ++i) {
            vec2 t = t0 + (vec2(i & 1, i >> 1) - 0.5) * (reach * view.texel);
            if (dot(axis, vec3(t, 1.0)) < above) continue;
            ShadowTexels texels = lookUp(view, receiver, t);
            vec4 z = perspective ? view.depth.y / (view.depth.x - min(texels.depths, vec4(0.999999)))
                                 : (texels.depths - view.depth.x) / view.depth.y;
            sum += dot(texels.blocked, z);
            count += dot(texels.blocked, vec4(1.0));
        }
        if (count > 0.0) {
            float blocker = sum / count, behind = max(p.z - blocker, 0.0);
            float penumbra = stratum * behind / view.texel;
            if (perspective) penumbra /= p.z * max(blocker, 1e-3 * p.z);
            kernel = clamp(penumbra, kernel, view.maxKernel);
        }
        // A sample that stands alone needs more steps in a wide penumbra; far from any, one look-up does.
        if (count == 0.0 || count == 16.0) {
            taps = 1;
        } else if (light.samples == 1u && kernel > 2.0) {
            taps = 4;
        }
    }

    // Taps in the middle of the strata of a square of half-width `kernel`; each is a bilinear mean of four comparisons.
    float lit = 0.0, valid = 0.0;
    for (int i = 0; i < taps * taps; ++i) {
        vec2 place = (vec2(i % taps, i / taps) + 0.5) / float(taps) * 2.0 - 1.0;
        vec2 t = t0 + place * (kernel * view.texel);
        if (dot(axis, vec3(t, 1.0)) < above) continue;
        ShadowTexels texels = lookUp(view, receiver, t);
        lit += dot(texels.weights, 1.0 - texels.blocked);
        valid += 1.0;
    }
    return valid > 0.0 ? lit / valid : 1.0;
}

// Face of the cube in the light's frame (right, up, direction) that looks along d: forward, right, left, up, down,
// backward, as light_layout.cpp lays them out.
uint cubeFace(Light light, vec3 d) {
    vec3 p = vec3(dot(d, light.right), dot(d, light.up), dot(d, light.direction));
    vec3 a = abs(p);
    if (a.z >= a.x && a.z >= a.y) return p.z >= 0.0 ? 0u : 5u;
    return a.x >= a.y ? (p.x >= 0.0 ? 1u : 2u) : (p.y >= 0.0 ? 3u : 4u);
}

/// What one sample point of a light gives to a receiver.
struct LightSample {
    vec3 toLight;      // unit
    float distance_;   // metres
    float share;       // not normalised: of the light's irradiance
    float visibility;  // 0 to 1
};

// Sample point `index` of `light`. n: shading normal (weights), geometric: geometric normal (shadows); both unit.
LightSample lightSample(Light light, uint index, vec3 pos, vec3 geometric, vec3 n, float slack) {
    LightSample s;
    uint first = light.firstView + index * light.faces;
    vec3 offset = light.position - pos;
    if (light.samples > 1u) offset = b_shadowViews[first].origin - pos;
    if (light.type == LIGHT_DIRECTIONAL) {
        offset = light.samples > 1u ? -b_shadowViews[first].forward : -light.direction;
    }
    float d2 = dot(offset, offset);
    s.distance_ = sqrt(d2);
    s.toLight = offset / s.distance_;
    s.share = 1.0;
    if (light.samples > 1u) {
        s.share = max(dot(n, s.toLight), 0.0) / d2;
        if (light.type == LIGHT_RECTANGLE) s.share *= max(-dot(light.direction, s.toLight), 0.0);
    }
    s.visibility = 0.0;
    if (s.share > 0.0 && dot(geometric, s.toLight) > 0.0) {
        uint face = light.faces == 1u ? 0u : cubeFace(light, -offset);
        s.visibility =
            face < light.faces ? sampleVisibility(light, b_shadowViews[first + face], pos, geometric, slack) : 0.0;
    }
    return s;
}

// ------------------------------------------------------------------------------------------------------------- together

/// Irradiance in W/m² from all lights, with shadows, at `pos` on a surface of unit `normal`. `slack`: how far, in metres,
/// pos may lie from the real surface along the normal (voxels know their surfaces less exactly than pixels do).
vec3 directIrradiance(vec3 pos, vec3 normal, float slack) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < u_lightCount; ++i) {
        Light light = b_lights[i];
        // The back of a panel that the light lies on may seem to be before its plane by as much.
        if (light.type == LIGHT_RECTANGLE && dot(light.position - pos - slack * normal, light.direction) >= 0.0) continue;
        vec3 irradiance = unshadowedIrradiance(light, pos, normal);
        if (all(equal(irradiance, vec3(0.0)))) continue;
        float shares = 0.0, seen = 0.0;
        for (uint k = 0u; k < light.samples; ++k) {
            LightSample s = lightSample(light, k, pos, normal, normal, slack);
            shares += s.share;
            seen += s.share * s.visibility;
        }
        // No sample point above the horizon, but a sliver of the light: less than a hundredth of its irradiance.
        sum += shares > 0.0 ? irradiance * (seen / shares) : irradiance;
    }
    return sum;
}

/// Radiance in W/(m² sr) towards the unit direction `toEye` from all lights, with shadows, by both lobes of `surface`.
/// Normals are unit and on the side of the eye.
/// Diffuse light of area lights is exact but for its visibility. Specular light treats every sample point as a point light
/// whose lobe is widened by the angle of its stratum (after Karis 2013): good for rough surfaces, and a smooth blob instead
/// of the light's outline on polished ones.
void directLight(Surface surface, vec3 pos, vec3 geometricNormal, vec3 shadingNormal, vec3 toEye, out vec3 diffuse,
                 out vec3 specular) {
    diffuse = vec3(0.0);
    specular = vec3(0.0);
    for (int i = 0; i < u_lightCount; ++i) {
        Light light = b_lights[i];
        vec3 irradiance = unshadowedIrradiance(light, pos, shadingNormal);
        if (all(equal(irradiance, vec3(0.0)))) continue;
        float shares = 0.0;
        vec3 diffuseSum = vec3(0.0), specularSum = vec3(0.0);
        for (uint k = 0u; k < light.samples; ++k) {
            LightSample s = lightSample(light, k, pos, geometricNormal, shadingNormal, 0.0);
            shares += s.share;
            if (s.visibility <= 0.0) continue;
            float seen = s.share * s.visibility;
            Surface widened = surface;
            widened.alpha = min(surface.alpha + 0.5 * light.stratumSize / s.distance_, 1.0);
            diffuseSum += seen * evaluateDiffuse(surface, shadingNormal, toEye, s.toLight);
            specularSum += seen * evaluateSpecular(widened, shadingNormal, toEye, s.toLight);
        }
        if (!(shares > 0.0)) continue;
        diffuse += irradiance * diffuseSum / shares;
        specular += irradiance * specularSum / shares;
    }
}

#endif
