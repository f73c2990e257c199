// Cones towards a light that together are as wide as the light looks from the surface: what they keep of their
// transmittance is the share of the light that is seen. The thesis (section 3.4.7) takes one; but the footprint cap makes
// that a thin one, and the gain steepens its edge, so that it gave hard shadows.
#include "frame/gbuffer.glsl"
#include "cone/trace.glsl"
#include "cone/cone_set.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform float u_inverseVoxelSize;
uniform vec3 u_lightPosition;    // relative to the scene's origin; a unit direction for a directional light
uniform float u_lightRadius;     // metres; sine of the angular radius for a directional light
uniform bool u_directional;
layout(r32f) uniform writeonly image2D u_visibility;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_visibility)))) return;
    GBufferSample s = loadGBuffer(pixel);
    float visibility = 1.0;
    if (s.hit) {
        vec3 toLight = u_directional ? u_lightPosition : u_lightPosition - s.position;
        float distance_ = length(toLight);
        Cone cone;
        cone.origin = s.position * u_inverseVoxelSize;
        cone.normal = s.geometricNormal;
        cone.level = 0.0;
        vec3 axis = toLight / distance_;
        float sine = min(u_lightRadius / distance_, 0.99);
        float tangent = sine * inversesqrt(1.0 - sine * sine);
        cone.tanHalfAngle = tangent * inversesqrt(float(CONES));
        cone.near = u_nearDistance;
        mat3 frame = frameAround(axis);
        // Short of the light by its radius and what filtering spreads: a lamp's own casing must not shade it.
        float edge = u_directional ? 1.0 : exp2(containmentLevel(u_lightPosition * u_inverseVoxelSize));
        float reach = max(distance_ - u_lightRadius, 0.0) * u_inverseVoxelSize - 2.0 * edge;
        visibility = 0.0;
        for (int i = 0; i < CONES; ++i) {
            // Equal shares of a disc, by the golden angle.
            float radius = tangent * sqrt((float(i) + 0.5) / float(CONES)), azimuth = 2.39996322972865332 * float(i);
            cone.direction = normalize(frame * vec3(radius * cos(azimuth), radius * sin(azimuth), 1.0));
            if (dot(cone.direction, cone.normal) <= 0.0) continue;
            visibility += traceConeTo(cone, u_directional ? 1e30 : reach).transmittance;
        }
        visibility /= float(CONES);
    }
    imageStore(u_visibility, pixel, vec4(visibility));
}
