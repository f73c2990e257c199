// Needs frame/gbuffer.glsl.
uniform sampler2D u_specularAlbedo;  // light/specular_table.h

/// A and B of f0·A + f90·B.
vec2 specularAlbedoParts(float nDotV, float alpha) {
    float texels = float(textureSize(u_specularAlbedo, 0).x);
    return textureLod(u_specularAlbedo, (vec2(nDotV, sqrt(alpha)) * (texels - 1.0) + 0.5) / texels, 0.0).rg;
}

/// Directional albedo of the surface's specular lobe towards the eye.
vec3 specularAlbedo(GBufferSample s) {
    vec2 parts = specularAlbedoParts(dot(s.normal, s.toEye), s.surface.alpha);
    return s.surface.f0 * parts.x + s.surface.f90 * parts.y;
}
