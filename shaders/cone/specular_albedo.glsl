// Needs frame/gbuffer.glsl.
uniform sampler2D u_specularAlbedo;  // light/specular_table.h

/// Directional albedo of the surface's specular lobe towards the eye.
vec3 specularAlbedo(GBufferSample s) {
    vec2 place = vec2(dot(s.normal, s.toEye), sqrt(s.surface.alpha));
    float texels = float(textureSize(u_specularAlbedo, 0).x);
    vec2 parts = textureLod(u_specularAlbedo, (place * (texels - 1.0) + 0.5) / texels, 0.0).rg;
    return s.surface.f0 * parts.x + s.surface.f90 * parts.y;
}
