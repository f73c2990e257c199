// The scene on the device: vertices, objects, materials and textures, and batches to draw them.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "gl/buffer.h"
#include "gl/framebuffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "scene/scene.h"

namespace voxcone::gl {

/// Triangles of one mesh that share material and closedness, in instances that agree in mirroring and in whether they
/// move.
struct Batch {
    int mesh = 0;
    int material = 0;
    bool closed = false;    ///< all triangles belong to watertight, outward-oriented bodies (Mesh::closed)
    bool mirrored = false;  ///< the instances' transforms mirror: front faces wind clockwise in the window
    bool moving = false;    ///< an animation may move or deform the instances (Scene::movingInstances)
    AlphaMode alphaMode = AlphaMode::opaque;
    bool doubleSided = false;
    bool emits = false;                            ///< the material emits (emission or unlit)
    bool leaves = false;                           ///< Scene::isLeaves
    bool transmits = false;                        ///< Material::transmits
    bool emitsToCones = false;                     ///< and analytic lights do not do so in its place
    std::uint32_t firstIndex = 0, indexCount = 0;  ///< in the index buffer
    std::int32_t baseVertex = 0;
    std::uint32_t firstObject = 0, objectCount = 0;  ///< instances: consecutive objects
};

/// Which batches a draw takes; empty = all.
using BatchFilter = std::function<bool(const Batch&)>;

enum class TextureFiltering { anisotropic, isotropic };

/// Uploads what drawing needs: one vertex array (gl/bindings.h, shaders/shared/objects.glsl), object and material
/// storage blocks, and the textures that materials use, with full mip chains (colour as sRGB). Scenes without textures
/// have none. Positions that shaders see are world positions minus `origin()`.
class GpuScene {
  public:
    /// `scene` must outlive this object. Throws DeviceError when a limit is too small.
    explicit GpuScene(const Scene& scene, double time = 0);

    /// Recomputes the objects' transforms, T(−origin) · world in double, then rounds to float.
    void setOrigin(const glm::dvec3& origin);
    /// Moves the objects to where `scene` has them at `time`, those too whose nodes were put elsewhere since, and
    /// uploads the vertices of those whose deformation changed.
    void setTime(double time);

    const Scene& scene() const { return scene_; }
    const glm::dvec3& origin() const { return origin_; }
    double time() const { return time_; }
    const std::vector<glm::dmat4>& worldMatrices() const { return pose_.nodes; }  ///< of nodes

    const std::vector<Batch>& batches() const { return batches_; }
    std::size_t objectCount() const { return objects_.size(); }
    const Instance& objectInstance(std::size_t object) const { return scene_.instances[objects_[object]]; }
    /// World-space box of an object at the current time (from the corners of its object-space box).
    const Bounds& objectBounds(std::size_t object) const { return instanceBounds_[objects_[object]]; }
    Bounds bounds() const;  ///< of all objects
    bool empty() const { return batches_.empty(); }
    std::uint64_t triangleCount() const;  ///< over all instances
    bool anyEmission() const;
    bool anyEmissionToCones() const;  ///< a batch with emitsToCones
    bool anyAlphaTest() const;        ///< a batch with AlphaMode mask or blend
    bool anyTransmission() const;     ///< a batch that transmits
    bool anyMoving() const;           ///< a batch that moves
    bool anyLeaves() const;           ///< a batch of leaves

    /// World boxes that objects have left and entered since the last call, or since the upload: two for each object
    /// whose matrix or vertices changed in any setTime() between, none for the others. The boxes hold the objects as
    /// they were at that call and as they are now; what was between has gone.
    struct Moved {
        std::vector<Bounds> moving;  ///< of objects that an animation may move
        std::vector<Bounds> fixed;   ///< of others, whose nodes were put elsewhere
    };
    Moved takeMoved();

    /// Draws the batches that `filter` takes with `program` in use, in an order fixed by the scene: binds the
    /// material's textures and block, sets u_closed (shared/material.glsl) and the winding of front faces.
    /// `filtering`: isotropic for shaders that choose the mip themselves, since what anisotropic filtering makes of an
    /// explicit level is the device's own (llvmpipe widens it by the derivatives of the draw).
    void draw(Program& program, const BatchFilter& filter = {},
              TextureFiltering filtering = TextureFiltering::anisotropic) const;

    /// The same for those triangles that may touch `worldBox`: clusters of neighbouring triangles (at most
    /// kClusterTriangles) whose boxes do, by what the device's floats make of their positions. Number of triangles
    /// drawn; a box that holds the scene draws all.
    std::uint64_t drawInside(Program& program, const Bounds& worldBox, const BatchFilter& filter = {},
                             TextureFiltering filtering = TextureFiltering::anisotropic) const;

    static constexpr std::uint32_t kClusterTriangles = 64;

    /// Binds the object block and the vertex array; `draw` does so itself.
    void bindStorage() const;

    /// Reverses the order of batches and of triangles inside them: for tests of order independence.
    void reverseDrawOrder();

    std::uint64_t bufferBytes() const;
    std::uint64_t textureBytes() const;

  private:
    /// Triangles of a mesh in the index buffer: those of watertight bodies, then the others, each sorted along a curve
    /// that fills space, so that kClusterTriangles in a row are neighbours.
    struct IndexRange {
        std::uint32_t firstClosed = 0, closedCount = 0, firstOpen = 0, openCount = 0;
    };
    /// Vertices that instances draw, with boxes in object space: those of a mesh, or of one deformed instance.
    struct Shape {
        int mesh = 0;
        int instance = -1;  ///< index in Scene::instances for a deformed one
        std::int32_t baseVertex = 0;
        Bounds bounds;
        std::vector<Bounds> closedClusters, openClusters;
    };

    void uploadGeometry();
    void uploadMaterials();
    void uploadTextures();
    void updateBatches();
    void uploadObjects();
    void updateShapeBounds(Shape& shape, const std::vector<glm::vec3>& positions) const;
    void uploadDeformed(Shape& shape);
    void drawBatches(Program& program, const BatchFilter& filter, TextureFiltering filtering,
                     const std::function<void(const Batch&)>& issue) const;

    const Scene& scene_;
    glm::dvec3 origin_{0};
    double time_ = 0;
    bool reversed_ = false;
    Pose pose_;
    std::vector<Batch> batches_;
    std::vector<std::size_t> objects_;  ///< object → index in Scene::instances
    // By index in Scene::instances: whether it may move, whether it did since takeMoved(), world boxes now and then.
    std::vector<std::uint8_t> moving_, moved_;
    std::vector<Bounds> instanceBounds_, takenBounds_;
    std::size_t materialStride_ = 0;       ///< bytes from one material's block to the next
    std::vector<std::uint8_t> leaves_;     ///< by index in Scene::materials: Scene::isLeaves
    std::vector<IndexRange> indexRanges_;  ///< by index in Scene::meshes
    std::vector<Shape> shapes_;            ///< by index in Scene::meshes, then those of deformed instances
    std::vector<std::size_t> shapeOf_;     ///< by index in Scene::instances
    std::vector<std::uint32_t> indices_;
    Buffer vertices_, indexBuffer_, objectIndices_, objectBuffer_, materialBuffer_;
    VertexArray vertexArray_;
    std::vector<Texture> colorTextures_, dataTextures_;  ///< by index in Scene::textures; empty where unused
    std::vector<Sampler> isotropicSamplers_;             ///< likewise
};

}  // namespace voxcone::gl
