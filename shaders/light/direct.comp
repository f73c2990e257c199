// Direct light of every pixel of the G-buffer, diffuse and specular together: radiance towards the eye, W/(m² sr).
#include "frame/gbuffer.glsl"
#include "light/lights.glsl"
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform writeonly image2D u_direct;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_direct)))) return;
    GBufferSample s = loadGBuffer(pixel);
    vec3 diffuse = vec3(0.0), specular = vec3(0.0);
    if (s.hit) {
        directLight(s.surface, s.position, s.geometricNormal, s.normal, s.toEye, diffuse, specular);
#ifdef GBUFFER_TRANSMISSION
        if (maxComponent(s.scattered) > 0.0) {
            diffuse += s.scattered * diffuseTransmission(s.surface, max(dot(s.normal, s.toEye), 0.0)) * kInvPi *
                       directIrradiance(s.position, -s.geometricNormal, 0.0);
        }
#endif
    }
    imageStore(u_direct, pixel, vec4(diffuse + specular, 1.0));
}
