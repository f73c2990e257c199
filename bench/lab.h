// Scenes of a known number of triangles, and the voxel passes that run on them.
#pragma once

#include <memory>

#include "bench.h"
#include "cascade/update.h"
#include "gl/gpu_scene.h"
#include "light/radiance.h"
#include "light/shadow_maps.h"
#include "voxelize/voxelizer.h"

namespace voxcone::bench {

/// A closed torus about y with waves on it, so that triangles look all ways: exactly `triangles`, which must be twice a
/// product of two counts of about equal size (10⁴, 10⁵, 10⁶, 10⁷ are). Radius 1 m and 0.45 m.
Scene torusScene(int triangles);

/// The same torus, of 10⁴ triangles, in a closed room, 4 m × 2.4 m × 4 m, lit by a sun through an opening in its roof.
Scene roomScene();

/// A scene with its voxels and their light, made by the passes of the renderer under their own names.
struct Lab {
    Lab(const Bench& bench, Scene givenScene, const Settings& givenSettings);

    /// Brings windows to a camera at `eye` (world), from nothing if `anew`, in a frame of its own; then, if `lit`, the
    /// light of what is new. Times are in `timers`.
    void update(const glm::dvec3& eye, bool anew, bool lit);

    /// Lights all voxels again, with all bounces, in a frame of its own.
    void relight();

    RadianceVolume volume() const { return field.volume(voxels); }

    const Scene scene;
    const Settings settings;
    gl::PassTimers timers;
    gl::GpuScene gpuScene;
    Voxelizer voxelizer;
    Voxels voxels;
    ClipmapSchedule schedule;
    ClipmapUpdate last;  ///< of the last update()
    Sky sky;
    ShadowMaps shadowMaps;
    RadianceField field;

  private:
    void light(const RadianceField::Change& change);
};

}  // namespace voxcone::bench
