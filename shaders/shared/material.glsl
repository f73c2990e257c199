// glTF metallic-roughness material of the batch that is drawn (gl::GpuScene): its constants and textures, sampled.
// GpuScene::draw binds the textures and the material's block. For fragment shaders.
#include "shared/bindings.glsl"

struct Material {
    vec4 baseColor;              // linear, alpha last
    vec4 emission;               // rgb radiance W/(m² sr); w: 1 for unlit
    vec4 metallicRoughness;      // metallic, roughness, normal scale, alpha cutoff
    vec4 specular;               // rgb: F0 of the dielectric at full specular factor; w: specular factor (F90)
    vec4 transmission;           // factor, thickness (metres in the mesh's space), index of refraction (at least 1), -
    vec4 absorption;             // rgb 1/m
    vec4 diffuseTransmission;    // rgb colour, w factor
    vec4 uvTransform[2 * MATERIAL_UNITS];  // two per slot, in the order of their units: rows (a, b, offset, -)
    ivec4 texCoord[MATERIAL_UNITS / 4];    // UV set of each slot
    ivec4 flags;                 // x: alpha mode (0 opaque, 1 mask, 2 blend), y: 1 double sided, 2 leaves, z: 1 unlit, 2 emission extracted, w: textures as bits
};
// A uniform block, not storage: pixels beside a triangle's edge, which give its derivatives, need not see storage (on
// llvmpipe they read zeros, and a texture coordinate made from those asks for the smallest mip).
layout(std140, binding = MATERIAL_BLOCK) uniform MaterialBlock { Material b_material; };

layout(binding = BASE_COLOR_UNIT) uniform sampler2D u_baseColorTexture;                  // decoded from sRGB
layout(binding = METALLIC_ROUGHNESS_UNIT) uniform sampler2D u_metallicRoughnessTexture;  // G roughness, B metallic
layout(binding = NORMAL_UNIT) uniform sampler2D u_normalTexture;
layout(binding = EMISSION_UNIT) uniform sampler2D u_emissionTexture;                     // decoded from sRGB
layout(binding = TRANSMISSION_UNIT) uniform sampler2D u_transmissionTexture;             // R
layout(binding = THICKNESS_UNIT) uniform sampler2D u_thicknessTexture;                   // G
layout(binding = DIFFUSE_TRANSMISSION_UNIT) uniform sampler2D u_diffuseTransmissionTexture;             // A
layout(binding = DIFFUSE_TRANSMISSION_COLOR_UNIT) uniform sampler2D u_diffuseTransmissionColorTexture;  // decoded from sRGB

uniform bool u_closed;   // the batch's triangles bound a watertight body

#define ALPHA_OPAQUE 0
#define ALPHA_MASK 1
#define ALPHA_BLEND 2

struct MaterialSample {
    vec3 baseColor;       // linear, for unlit materials zero (they reflect nothing)
    float alpha;          // opacity; 1 for opaque materials
    float metallic;
    float roughness;      // perceptual, [0,1]
    vec3 emission;        // radiance; for unlit materials their colour
    vec3 normalTS;        // tangent space, unit; (0,0,1) without a normal map
    vec3 f0Dielectric;    // KHR_materials_ior and _specular: reflectance of the dielectric at normal incidence
    float specularFactor; // F90 of the dielectric
    float transmission;   // share of the light that enters which passes through, tinted by the base colour
    float thickness;      // metres in the mesh's space; 0 = thin sheet
    float diffuseTransmission;      // share of what is left that is scattered to the other side, …
    vec3 diffuseTransmissionColor;  // … tinted by this
};

bool materialHas(int slot) { return (b_material.flags.w & (1 << slot)) != 0; }
bool materialDoubleSided() { return (b_material.flags.y & 1) != 0; }
bool materialLeaves() { return (b_material.flags.y & 2) != 0; }
bool materialUnlit() { return b_material.flags.z == 1; }
bool materialExtracted() { return b_material.flags.z == 2; }  // analytic lights stand for its emission
int materialAlphaMode() { return b_material.flags.x; }
float materialAlphaCutoff() { return b_material.metallicRoughness.w; }

int materialTexCoord(int slot) { return b_material.texCoord[slot / 4][slot % 4]; }

vec2 materialUv(int slot, vec2 uv0, vec2 uv1) {
    vec3 uv = vec3(materialTexCoord(slot) == 0 ? uv0 : uv1, 1.0);
    return vec2(dot(b_material.uvTransform[2 * slot].xyz, uv),
                dot(b_material.uvTransform[2 * slot + 1].xyz, uv));
}

// The material from its texels, in the order of their units; those of absent textures must be white (normal: flat).
MaterialSample materialFromTexels(vec4 texels[MATERIAL_UNITS], vec4 vertexColor) {
    vec4 baseColor = texels[BASE_COLOR_UNIT], metallicRoughness = texels[METALLIC_ROUGHNESS_UNIT];
    vec4 normal = texels[NORMAL_UNIT], emission = texels[EMISSION_UNIT];
    Material m = b_material;
    MaterialSample s;
    vec4 color = m.baseColor * vertexColor;
    if (materialHas(BASE_COLOR_UNIT)) color *= baseColor;
    s.alpha = m.flags.x == ALPHA_OPAQUE ? 1.0 : clamp(color.a, 0.0, 1.0);
    s.metallic = m.metallicRoughness.x;
    s.roughness = m.metallicRoughness.y;
    if (materialHas(METALLIC_ROUGHNESS_UNIT)) {
        s.metallic *= metallicRoughness.b;
        s.roughness *= metallicRoughness.g;
    }
    s.normalTS = vec3(0.0, 0.0, 1.0);
    if (materialHas(NORMAL_UNIT)) {
        vec3 n = (normal.xyz * 2.0 - 1.0) * vec3(m.metallicRoughness.zz, 1.0);
        s.normalTS = dot(n, n) > 0.0 ? normalize(n) : vec3(0.0, 0.0, 1.0);
    }
    s.emission = m.emission.rgb;
    if (materialHas(EMISSION_UNIT)) s.emission *= emission.rgb;
    bool unlit = materialUnlit();
    if (unlit) s.emission = color.rgb;
    s.baseColor = unlit ? vec3(0.0) : color.rgb;
    s.f0Dielectric = unlit ? vec3(0.0) : m.specular.rgb;
    s.specularFactor = unlit ? 0.0 : m.specular.w;
    float dielectric = 1.0 - s.metallic;
    s.transmission = m.transmission.x * texels[TRANSMISSION_UNIT].r * dielectric;
    s.thickness = m.transmission.y * texels[THICKNESS_UNIT].g;
    s.diffuseTransmission = m.diffuseTransmission.w * texels[DIFFUSE_TRANSMISSION_UNIT].a * dielectric;
    s.diffuseTransmissionColor = m.diffuseTransmission.rgb * texels[DIFFUSE_TRANSMISSION_COLOR_UNIT].rgb;
    return s;
}

// With the derivatives of the draw: call in uniform control flow.
MaterialSample sampleMaterial(vec2 uv0, vec2 uv1, vec4 vertexColor) {
    vec4 texels[MATERIAL_UNITS];
    for (int slot = 0; slot < MATERIAL_UNITS; ++slot) texels[slot] = slot == NORMAL_UNIT ? vec4(0.5, 0.5, 1.0, 1.0) : vec4(1.0);
#define SAMPLE(slot, tex) if (materialHas(slot)) texels[slot] = texture(tex, materialUv(slot, uv0, uv1));
    SAMPLE(BASE_COLOR_UNIT, u_baseColorTexture)
    SAMPLE(METALLIC_ROUGHNESS_UNIT, u_metallicRoughnessTexture)
    SAMPLE(NORMAL_UNIT, u_normalTexture)
    SAMPLE(EMISSION_UNIT, u_emissionTexture)
    SAMPLE(TRANSMISSION_UNIT, u_transmissionTexture)
    SAMPLE(THICKNESS_UNIT, u_thicknessTexture)
    SAMPLE(DIFFUSE_TRANSMISSION_UNIT, u_diffuseTransmissionTexture)
    SAMPLE(DIFFUSE_TRANSMISSION_COLOR_UNIT, u_diffuseTransmissionColorTexture)
#undef SAMPLE
    return materialFromTexels(texels, vertexColor);
}

/// Share of light that goes straight through the sheet, or through the whole body
/// where the triangle belongs to one. `scale`: world length of a unit of the mesh; `schlick`: weight of Schlick's Fresnel.
vec3 materialTransmittance(MaterialSample s, float scale, float schlick) {
    if (s.transmission <= 0.0) return vec3(0.0);
    float f0 = max(s.f0Dielectric.r, max(s.f0Dielectric.g, s.f0Dielectric.b));
    vec3 once = s.baseColor * (s.transmission * (1.0 - mix(f0, s.specularFactor, schlick)));
    return (u_closed ? once * once : once) * exp(-b_material.absorption.rgb * (s.thickness * scale));
}

/// Threshold that the opacity of the drawn fragment is tested against. `random`: uniform in (0,1) over fragments; a
/// blended surface stops that part of them which is its opacity. So does a masked one where its texture is minified:
/// filtering makes its opacity the share of the texels that are there, and to cut that off would thin out foliage and
/// lattices with the distance until they are gone (after Wyman and McGuire 2017, "Hashed Alpha Testing").
float materialAlphaThreshold(vec2 uv0, vec2 uv1, float random) {
    if (materialAlphaMode() == ALPHA_BLEND) return random;
    if (!materialHas(BASE_COLOR_UNIT)) return materialAlphaCutoff();
    float lod = textureQueryLod(u_baseColorTexture, materialUv(BASE_COLOR_UNIT, uv0, uv1)).y;
    return mix(materialAlphaCutoff(), random, clamp(lod, 0.0, 1.0));
}

// With the uv area that one sample stands for: uvPerSample0 and uvPerSample1 are the lengths, in units of UV sets 0 and 1,
// that a voxel (or any footprint) covers on the surface; the mip whose texels are that large is taken. For voxelization,
// where the derivatives of the draw mean nothing.
MaterialSample sampleMaterialFootprint(vec2 uv0, vec2 uv1, vec4 vertexColor, float uvPerSample0, float uvPerSample1) {
    vec4 texels[MATERIAL_UNITS];
    for (int slot = 0; slot < MATERIAL_UNITS; ++slot) texels[slot] = slot == NORMAL_UNIT ? vec4(0.5, 0.5, 1.0, 1.0) : vec4(1.0);
#define SAMPLE_FOOTPRINT(slot, tex)                                                                          \
    if (materialHas(slot)) {                                                                                 \
        float perSample = materialTexCoord(slot) == 0 ? uvPerSample0 : uvPerSample1;                         \
        vec3 row0 = b_material.uvTransform[2 * slot].xyz;                                       \
        vec3 row1 = b_material.uvTransform[2 * slot + 1].xyz;                                   \
        float scale = sqrt(abs(row0.x * row1.y - row0.y * row1.x));                                          \
        vec2 size = vec2(textureSize(tex, 0));                                                               \
        float lod = log2(max(perSample * scale * sqrt(size.x * size.y), 1.0));                               \
        texels[slot] = textureLod(tex, materialUv(slot, uv0, uv1), lod);                                     \
    }
    SAMPLE_FOOTPRINT(BASE_COLOR_UNIT, u_baseColorTexture)
    SAMPLE_FOOTPRINT(METALLIC_ROUGHNESS_UNIT, u_metallicRoughnessTexture)
    SAMPLE_FOOTPRINT(NORMAL_UNIT, u_normalTexture)
    SAMPLE_FOOTPRINT(EMISSION_UNIT, u_emissionTexture)
    SAMPLE_FOOTPRINT(TRANSMISSION_UNIT, u_transmissionTexture)
    SAMPLE_FOOTPRINT(THICKNESS_UNIT, u_thicknessTexture)
    SAMPLE_FOOTPRINT(DIFFUSE_TRANSMISSION_UNIT, u_diffuseTransmissionTexture)
    SAMPLE_FOOTPRINT(DIFFUSE_TRANSMISSION_COLOR_UNIT, u_diffuseTransmissionColorTexture)
#undef SAMPLE_FOOTPRINT
    return materialFromTexels(texels, vertexColor);
}
