// Reads the G-buffer (src/frame/gbuffer.h). GBuffer::bind sets all uniforms. Positions are relative to the scene's origin.
#include "shared/brdf.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"

uniform usampler2D u_gbufferSurface;
uniform sampler2D u_gbufferBaseColor;
uniform sampler2D u_gbufferSpecular;
#ifdef GBUFFER_EMISSION
uniform sampler2D u_gbufferEmission;
#endif
#ifdef GBUFFER_TRANSMISSION
uniform usampler2D u_gbufferTransmission;
uniform sampler2D u_gbufferScattered;
#endif
uniform vec3 u_cameraPosition;
uniform mat3 u_cameraRays;  // times (x, y, 1) of a place in the window in pixels: ray of length 1 along the view

struct GBufferSample {
    bool hit;              // false: background; then only toEye means something
    float viewDepth;       // distance along the view, metres
    vec3 position;
    vec3 toEye;            // unit
    vec3 normal;           // unit, for shading: turned so that the eye and its mirror image are above it
    vec3 geometricNormal;  // unit, of the triangle, towards the eye
    vec3 baseColor;
    float metallic;
    float roughness;
    vec3 emission;         // radiance W/(m² sr)
    Surface surface;       // reflects nothing for unlit materials
    vec3 beam;             // share of the light that enters the surface and goes on as a beam
    vec3 scattered;        // share that leaves on the other side as from a Lambert surface
    bool closed;           // of what transmits: the triangle bounds a closed body, …
    bool solid;            // … which is filled with a medium, …
    float ior;             // … of this index of refraction
    float thickness;       // metres; of a solid no more than a scale
    vec3 opticalDepth;     // absorption over `thickness`
};

ivec2 gbufferSize() { return textureSize(u_gbufferSurface, 0); }

// Position alone, for filters that compare neighbours; distance 0 is background.
float gbufferViewDepth(ivec2 pixel) { return uintBitsToFloat(texelFetch(u_gbufferSurface, pixel, 0).w); }
vec3 gbufferNormal(ivec2 pixel) { return unpackOctahedral(texelFetch(u_gbufferSurface, pixel, 0).x); }
vec3 gbufferRay(ivec2 pixel) { return u_cameraRays * vec3(vec2(pixel) + 0.5, 1.0); }

// The path tracer's rule for shading normals that look away from the eye (src/reference/path_tracer.cpp, makeVertex): a
// mirror image from below the triangle would be black, so it is lifted above and the normal put half-way (Keller et al.,
// "The Iray Light Transport Simulation and Rendering System", 2017).
vec3 visibleShadingNormal(vec3 normal, vec3 plane, vec3 toEye, Surface surface) {
    const float minViewCosine = 1e-3, minMirrorCosine = 0.01;
    float cosine = dot(normal, toEye);
    if (maxComponent(surface.f0) > 0.0 || surface.f90 > 0.0) {
        vec3 mirrored = 2.0 * cosine * normal - toEye;
        float above = dot(mirrored, plane);
        float wanted = min(0.9 * dot(toEye, plane), minMirrorCosine);
        return above < wanted ? normalize(toEye + normalize(mirrored + (wanted - above) * plane)) : normal;
    }
    return cosine < minViewCosine ? normalize(normal + (minViewCosine - cosine) * toEye) : normal;
}

GBufferSample loadGBuffer(ivec2 pixel) {
    GBufferSample s;
    uvec4 words = texelFetch(u_gbufferSurface, pixel, 0);
    vec3 ray = gbufferRay(pixel);
    s.viewDepth = uintBitsToFloat(words.w);
    s.hit = s.viewDepth > 0.0;
    s.position = u_cameraPosition + ray * s.viewDepth;
    s.toEye = -normalize(ray);
    s.geometricNormal = unpackOctahedral(words.y);
    vec2 metallicRoughness = unpackUnorm2x16(words.z);
    s.metallic = metallicRoughness.x;
    s.roughness = metallicRoughness.y;
    vec4 baseColor = texelFetch(u_gbufferBaseColor, pixel, 0);
    vec4 specular = texelFetch(u_gbufferSpecular, pixel, 0);
    s.baseColor = baseColor.rgb;
    s.surface.diffuseColor = s.baseColor * ((1.0 - s.metallic) * specular.a);
    s.surface.f0 = mix(specular.rgb, s.baseColor, s.metallic) * specular.a;
    s.surface.f90 = mix(baseColor.a, 1.0, s.metallic) * specular.a;
    s.surface.alpha = clamp(s.roughness * s.roughness, kMinAlpha, 1.0);
    s.beam = s.scattered = s.opticalDepth = vec3(0.0);
    s.closed = s.solid = false;
    s.ior = 1.0, s.thickness = 0.0;
#ifdef GBUFFER_TRANSMISSION
    uvec4 transmission = texelFetch(u_gbufferTransmission, pixel, 0);
    vec4 scattered = texelFetch(u_gbufferScattered, pixel, 0);
    vec2 shareAndClosed = unpackUnorm2x16(transmission.x), iorAndSolid = unpackHalf2x16(transmission.y);
    s.closed = shareAndClosed.y > 0.5;
    s.solid = iorAndSolid.y > 0.5;
    s.ior = max(iorAndSolid.x, 1.0);
    s.thickness = uintBitsToFloat(transmission.z);
    s.opticalDepth = unpackRgb9e5(transmission.w);
    s.beam = s.baseColor * shareAndClosed.x;
    if (!s.solid) s.beam *= exp(-s.opticalDepth);
    s.scattered = scattered.rgb * (scattered.a * (1.0 - shareAndClosed.x));
    s.surface.diffuseColor *= (1.0 - shareAndClosed.x) * (1.0 - scattered.a);
#endif
    s.normal = visibleShadingNormal(unpackOctahedral(words.x), s.geometricNormal, s.toEye, s.surface);
#ifdef GBUFFER_EMISSION
    s.emission = texelFetch(u_gbufferEmission, pixel, 0).rgb;
#else
    s.emission = vec3(0.0);
#endif
    return s;
}
