// The voxels of all levels on the device: a pool of records, and volumes that find and filter them.
#pragma once

#include <cstdint>
#include <vector>

#include "cascade/buffers.h"
#include "cascade/update.h"
#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/texture.h"

namespace voxcone {

/// The voxelized scene. Only voxels that a surface touches have a record; a record keeps its slot while it lives.
struct Voxels {
    ClipmapLayout layout;
    glm::dvec3 origin{0};           ///< world position of voxel index 0
    glm::dvec3 center{0};           ///< camera, relative to the origin: where level 0 is centred, metres
    std::vector<VoxelBox> windows;  ///< by level, mips too; empty before the first update

    bool emits = false;   ///< some surface may emit
    bool leaves = false;  ///< some surface is a leaf (Scene::isLeaves) and settings composite leaves apart

    gl::Texture index;        ///< R32UI: 1 + slot of static geometry's record and of mips, 0 where nothing is
    gl::Texture movingIndex;  ///< the same of moving geometry; absent without any
    /// RGB10_A2: coverage per edge of the level's voxel of surfaces that look along +xyz and −xyz; isotropic storage
    /// has the first alone, with opacity in r.
    gl::Texture coveragePositive, coverageNegative;
    /// R11F_G11F_B10F: optical depth of leaves along x, y and z per edge of the level's voxel, which the coverage then
    /// leaves out; absent without leaves.
    gl::Texture leafDepth;
    gl::Buffer places;    ///< by slot: packPlace, or 0 while free
    gl::Buffer faces;     ///< six FaceRecord a slot
    gl::Buffer emission;  ///< six RGB9E5 a slot; absent where nothing emits
    gl::Buffer coverage;  ///< uvec2 a slot: packed coverage of +xyz and −xyz, of leaves too
    gl::Buffer matter;    ///< uvec4 a slot: the same without leaves, and the leaves' depths; absent without leaves
    gl::Buffer freeSlots, fresh;
    std::uint32_t capacity = 0;        ///< records that the buffers hold
    std::uint32_t slots = 0;           ///< slots that were ever in use
    std::uint32_t freeCount = 0;       ///< of them free again
    std::uint32_t freshCount = 0;      ///< surface records of the last update: the slots that `fresh` begins with
    VoxelCounters counters;            ///< of the last update
    std::uint64_t trianglesDrawn = 0;  ///< in the last update, all passes and regions

    std::uint32_t occupied() const { return slots - freeCount; }
    bool anyMoving() const { return static_cast<bool>(movingIndex); }
    bool sixFace() const { return static_cast<bool>(coverageNegative); }
    std::uint64_t volumeBytes() const;
    std::uint64_t recordBytes() const;

    /// Half the edge of the cube around the centre inside which level 0 may be read, in voxels of level 0;
    /// layout.radius() unless windows lag behind the camera.
    double radius() const;
    /// The region outside of which nothing may be read: lower and upper corner in voxels of level 0. `anyCamera`: not
    /// the part around the camera that no snap changes, but all that the last window holds.
    std::pair<glm::dvec3, glm::dvec3> readable(bool anyCamera = false) const;

    /// Sets the uniforms of shaders/cascade/clipmap.glsl.
    void setClipmapUniforms(gl::Program& program) const;
    /// Binds the index volumes from texture unit `unit` on, as u_index and u_movingIndex.
    void bindIndex(gl::Program& program, int unit) const;
    /// What a shader needs to find records: the clipmap, the index volumes, and the faces at kFaceStorage.
    void bindRecords(gl::Program& program, int unit) const;
};

}  // namespace voxcone
