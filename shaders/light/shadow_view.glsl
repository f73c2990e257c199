// A tile of the shadow atlas. Twin of ShadowViewRecord in src/light/light_layout.h, where the fields are explained.
#ifndef VOXCONE_SHADOW_VIEW_GLSL
#define VOXCONE_SHADOW_VIEW_GLSL

#define SHADOW_VIEW_STORAGE 4  // twin in src/light/shadow_maps.h

struct ShadowView {
    vec3 origin;
    float texel;
    vec3 right;
    float scale;
    vec3 up;
    float perspective;
    vec3 forward;
    float maxKernel;
    vec2 tileCenter, tileHalfSize;
    vec2 depth;
    float filterRadius;
    float padding;
};
layout(std430, binding = SHADOW_VIEW_STORAGE) readonly buffer ShadowViews { ShadowView b_shadowViews[]; };

#endif
