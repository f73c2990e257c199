// Diffuse cones of every pixel: mean radiance over the cosine-weighted hemisphere (irradiance / π) with the sky, and
// openness in a.
#include "frame/gbuffer.glsl"
#include "cone/sky.glsl"
#include "cone/trace.glsl"
#include "cone/cone_set.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

uniform float u_inverseVoxelSize;
#if CASCADES
uniform bool u_coarserSide;  // where levels blend, read the coarser one alone: one side of the seam
#endif
uniform ivec2 u_firstPixel;  // of this dispatch
layout(rgba32f) uniform writeonly image2D u_gathered;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) + u_firstPixel;
    if (any(greaterThanEqual(pixel, imageSize(u_gathered)))) return;
    GBufferSample s = loadGBuffer(pixel);
    vec4 sum = vec4(0.0, 0.0, 0.0, 1.0);
    if (s.hit) {
        sum = vec4(0.0);
        Cone cone;
        cone.origin = s.position * u_inverseVoxelSize;
        cone.normal = s.geometricNormal;
        cone.level = 0.0;
        cone.near = u_nearDistance;
#if CASCADES
        if (u_coarserSide) {
            vec2 level = containment(cone.origin);
            if (level.y > 0.0) cone.level = level.x + 1.0;
        }
#endif
        cone.tanHalfAngle = u_coneTanHalfAngle;
        mat3 frame = frameAround(s.normal);
        vec2 orientation = orientationOf(pixel);
        for (int i = 0; i < CONES; ++i) {
            vec4 local = coneOfSet(i, orientation.x, orientation.y);
            cone.direction = frame * local.xyz;
            ConeResult result = traceCone(cone);
            sum += local.w * vec4(result.radiance + result.transmittance * skyRadiance(cone.direction, cone.tanHalfAngle),
                                  result.openness);
        }
    }
    storeSamples();
    imageStore(u_gathered, pixel, sum);
}
