// Cones towards the lights, which together are as wide as a light looks from the surface: what they keep of their
// transmittance is the share of it that is seen (thesis, section 3.4.7, with one cone). Lights count by the irradiance that
// they would give without shadows.
#include "frame/gbuffer.glsl"
#include "light/lights.glsl"
#include "cone/trace.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform float u_inverseVoxelSize;
layout(r32f) uniform writeonly image2D u_visibility;

const float kGolden = 0.61803398874989485;

/// Share of a light that a surface sees.
float coneVisibility(Light light, vec3 position, vec3 geometric, vec3 normal) {
    vec3 toLight = light.type == LIGHT_DIRECTIONAL ? -light.direction : light.position - position;
    float distance_ = length(toLight);
    vec3 axis = toLight / distance_;
    // A sphere is the disc that its tangents touch, in the plane of its centre.
    float sine = light.type == LIGHT_SPHERE        ? min(light.radius / distance_, 0.99)
                 : light.type == LIGHT_DIRECTIONAL ? light.radius
                                                   : 0.0;
    float radius = distance_ * sine * inversesqrt(1.0 - sine * sine);
    vec3 right = normalize(cross(axis, abs(axis.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
    vec3 up = cross(right, axis);
    bool wide = light.type == LIGHT_RECTANGLE || sine > 0.0;
    int cones = wide ? SHADOW_CONES : 1;
    float area = light.type == LIGHT_RECTANGLE ? 4.0 * light.halfWidth * light.halfHeight : kPi * radius * radius;
    float part = sqrt(area / (kPi * float(cones)));  // radius of the disc that is a cone's share
    float seen = 0.0, shares = 0.0;
    for (int i = 0; i < SHADOW_CONES; ++i) {
        if (i >= cones) break;
        float u = (float(i) + 0.5) / float(cones), v = fract((float(i) + 0.5) * kGolden);
        vec3 at = toLight;
        float share = 1.0;
        if (light.type == LIGHT_RECTANGLE) {
            at += (2.0 * u - 1.0) * light.halfWidth * light.right + (2.0 * v - 1.0) * light.halfHeight * light.up;
        } else if (cones > 1) {
            at += radius * sqrt(u) * (cos(2.0 * kPi * v) * right + sin(2.0 * kPi * v) * up);
        }
        float reach = length(at);
        Cone cone;
        cone.origin = position * u_inverseVoxelSize;
        cone.normal = geometric;
        cone.level = 0.0;
        cone.direction = at / reach;
        cone.tanHalfAngle = part / reach;
        cone.near = u_nearDistance;
        if (wide) share = max(dot(normal, cone.direction), 0.0) / (reach * reach);
        if (light.type == LIGHT_RECTANGLE) share *= max(-dot(light.direction, cone.direction), 0.0);
        if (!(share > 0.0)) continue;
        shares += share;
        if (dot(cone.direction, geometric) <= 0.0) continue;
        // Short of the light by its radius and what filtering spreads: a lamp's own casing must not shade it.
        float edge = exp2(containmentLevel(light.position * u_inverseVoxelSize));
        float end = light.type == LIGHT_DIRECTIONAL
                        ? 1e30
                        : (reach - (light.type == LIGHT_SPHERE ? light.radius : 0.0)) * u_inverseVoxelSize - 2.0 * edge;
        seen += share * traceConeTo(cone, end).transmittance;
    }
    return shares > 0.0 ? seen / shares : 0.0;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_visibility)))) return;
    GBufferSample s = loadGBuffer(pixel);
    float seen = 0.0, all = 0.0;
    if (s.hit) {
        for (int i = 0; i < u_lightCount; ++i) {
            Light light = b_lights[i];
            float weight = dot(unshadowedIrradiance(light, s.position, s.normal), vec3(0.2126, 0.7152, 0.0722));
            if (!(weight > 0.0)) continue;
            all += weight;
            seen += weight * coneVisibility(light, s.position, s.geometricNormal, s.normal);
        }
    }
    // What faces away from all lights is dark.
    float visibility = s.hit ? (all > 0.0 ? seen / all : 0.0) : 1.0;
    imageStore(u_visibility, pixel, vec4(visibility));
}
