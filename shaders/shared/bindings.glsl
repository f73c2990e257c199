// Binding points that scene data always has. Twin of src/gl/bindings.h.
#define BASE_COLOR_UNIT 0
#define METALLIC_ROUGHNESS_UNIT 1
#define NORMAL_UNIT 2
#define EMISSION_UNIT 3
#define ENVIRONMENT_UNIT 4
#define PASS_TEXTURE_UNIT 5

#define OBJECT_STORAGE 0

#define MATERIAL_BLOCK 0

#define POSITION_LOCATION 0
#define NORMAL_LOCATION 1
#define TANGENT_LOCATION 2
#define TEX_COORD_0_LOCATION 3
#define TEX_COORD_1_LOCATION 4
#define COLOR_LOCATION 5
#define OBJECT_INDEX_LOCATION 6
