// Surface of the pixel, packed as shaders/frame/gbuffer.glsl reads it. Conventions are those of the path tracer: back faces
// of single-sided materials are culled by the draw, normals are turned to the viewer, and a shading normal that leans
// behind its own triangle gives way to the triangle's.
#include "shared/material.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"

in vec3 v_fromEye;
in vec3 v_normal;
in vec4 v_tangent;
in vec4 v_texCoord;
in vec4 v_color;
flat in uint v_object;
flat in float v_scale;

layout(location = 0) out uvec4 o_surface;   // shading normal, geometric normal, metallic and roughness, distance along the view
layout(location = 1) out vec4 o_baseColor;  // rgb base colour, a F90 of the dielectric
layout(location = 2) out vec4 o_specular;   // rgb F0 of the dielectric, a 0 for unlit materials, else 1
#ifdef GBUFFER_EMISSION
layout(location = 3) out vec4 o_emission;   // radiance W/(m² sr)
#endif
#ifdef GBUFFER_TRANSMISSION
// Transmitted share and whether the triangle is of a closed body; index of refraction and whether that is a solid;
// thickness in metres (of a solid a length for scale); absorption over the thickness.
layout(location = GBUFFER_TRANSMISSION) out uvec4 o_transmission;
layout(location = GBUFFER_SCATTERED) out vec4 o_scattered;  // colour and share of diffuse transmission
#endif

#ifdef ALPHA_TEST
// PCG hash of three words (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering", pcg3d).
uvec3 pcg3d(uvec3 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// Opacity is the chance that a pixel stops: the threshold is a hash of pixel, object and distance, so that a picture does
// not depend on the order of drawing and a still camera gives a still picture.
float fragmentHash(float viewDepth) {
    uint key = uint(gl_FragCoord.x) | (uint(gl_FragCoord.y) << 16u);
    return (float(pcg3d(uvec3(key, v_object, floatBitsToUint(viewDepth))).x >> 8u) + 0.5) / 16777216.0;
}
#endif

void main() {
    float viewDepth = 1.0 / gl_FragCoord.w;
    MaterialSample material = sampleMaterial(v_texCoord.xy, v_texCoord.zw, v_color);
    vec3 plane = cross(dFdx(v_fromEye), dFdy(v_fromEye));
#ifdef ALPHA_TEST
    if (material.alpha < materialAlphaThreshold(v_texCoord.xy, v_texCoord.zw, fragmentHash(viewDepth))) discard;
#endif

    vec3 normal = dot(v_normal, v_normal) > 0.0 ? normalize(v_normal) : vec3(0.0);
    // Derivatives of a triangle seen edge-on may vanish: then its own normal is the better guess.
    float planeLength = length(plane);
    plane = planeLength > 0.0 ? plane / planeLength : normal;
    if (dot(plane, v_fromEye) > 0.0) plane = -plane;
    if (!(dot(plane, plane) > 0.5)) plane = -normalize(v_fromEye);

    if (materialHas(NORMAL_UNIT) && dot(v_tangent.xyz, v_tangent.xyz) > 0.0) {
        vec3 t = v_tangent.xyz - normal * dot(normal, v_tangent.xyz);
        t = dot(t, t) > 0.0 ? normalize(t) : vec3(0.0);
        vec3 b = (v_tangent.w < 0.0 ? -1.0 : 1.0) * cross(normal, t);
        vec3 mapped = material.normalTS.x * t + material.normalTS.y * b + material.normalTS.z * normal;
        if (dot(mapped, mapped) > 0.0) normal = normalize(mapped);
    }
    if (!gl_FrontFacing) normal = -normal;
    if (!(dot(normal, plane) > 0.0)) normal = plane;

    o_surface = uvec4(packOctahedral(normal), packOctahedral(plane),
                      packUnorm2x16(vec2(material.metallic, material.roughness)), floatBitsToUint(viewDepth));
    bool unlit = materialUnlit();
    // What an unlit surface shows is its base colour.
    o_baseColor = vec4(unlit ? material.emission : material.baseColor, material.specularFactor);
    o_specular = vec4(material.f0Dielectric, unlit ? 0.0 : 1.0);
#ifdef GBUFFER_TRANSMISSION
    bool solid = u_closed && b_material.transmission.y > 0.0;
    float thickness = v_scale * (solid ? b_material.transmission.y : material.thickness);
    o_transmission = uvec4(packUnorm2x16(vec2(material.transmission, u_closed ? 1.0 : 0.0)),
                           packHalf2x16(vec2(b_material.transmission.z, solid ? 1.0 : 0.0)), floatBitsToUint(thickness),
                           packRgb9e5(b_material.absorption.rgb * thickness));
    o_scattered = vec4(material.diffuseTransmissionColor, material.diffuseTransmission);
#endif
#ifdef GBUFFER_EMISSION
    o_emission = vec4(material.emission, 0.0);
#endif
}
