// The one tree of settings. Every field is described once, in `fields`, and that description serves JSON, `--set
// a.b=c`,
// `--help`, the viewer's panels and reports.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <variant>
#include <vector>

namespace voxcone {

enum class ToneMap : int { linear, reinhard, aces };
enum class VoxelStorage : int { isotropic, six_face, sh1 };
enum class VoxelAveraging : int { integer_sum, compare_and_swap };
enum class VoxelCoverage : int { area, binary };
enum class CascadeCenter : int { camera, window };
enum class CascadeUpdate : int { exact, budget };
enum class Compositing : int { linear, exponential, alpha };
enum class StartOffset : int { normal, nudge };
enum class SpecularAperture : int { ggx, linear };
enum class AoFalloff : int { none, linear, square_root };
enum class PassTimer : int { automatic, query, finish };

/// Defaults are the preset `balanced`.
struct Settings {
    struct Output {
        int width = 640, height = 360;
        int supersample = 1;
        double exposure = 0;
        ToneMap toneMap = ToneMap::aces;
    } output;
    struct Voxel {
        int resolution = 128;
        VoxelStorage storage = VoxelStorage::six_face;
        VoxelAveraging averaging = VoxelAveraging::integer_sum;
        VoxelCoverage coverage = VoxelCoverage::area;
        bool conservative = true;
        int margin = 2;
        double size = 0;
    } voxel;
    struct Cascade {
        int levels = 1;
        int snap = 4;
        double band = 0.15;
        CascadeCenter center = CascadeCenter::camera;
        CascadeUpdate update = CascadeUpdate::exact;
        int budget = 1;
    } cascade;
    struct Light {
        int shadowResolution = 2048;
        double shadowFilter = 1.5;
        int bounces = 3;
        double tolerance = 0;
        int bounceCones = 6;
        bool extrapolate = true;
        int extractEnvironment = 4;
        int extractEmitters = 8;
    } light;
    struct Cone {
        int diffuse = 16;
        double step = 1;
        Compositing compositing = Compositing::linear;
        double gain = 1.65;
        double footprintCap = 12;
        StartOffset start = StartOffset::normal;
        double offset = 0.75;
        double nearField = 16;
        double nudge = 1;
        bool rotate = true;
        double maxDistance = 0;
    } cone;
    struct Specular {
        bool enabled = true;
        SpecularAperture aperture = SpecularAperture::ggx;
        int cones = 4;
        double step = 1;
    } specular;
    struct Ao {
        double distance = 0;
        AoFalloff falloff = AoFalloff::none;
    } ao;
    struct Shadow {
        bool cones = false;
        int coneCount = 16;
    } shadow;
    struct Reference {
        int samples = 256;
        double error = 0;
        int maxDepth = 64;
        int seed = 1;
    } reference;
    struct Device {
        PassTimer timer = PassTimer::automatic;
    } device;
};

/// One leaf of the tree: where it is and what it may hold.
struct Field {
    struct Choice {
        std::function<int()> get;
        std::function<void(int)> set;
        std::vector<std::string> names;  ///< in the order of the enumeration's values
    };
    std::string key;  ///< dotted, e.g. "cone.gain"
    std::variant<bool*, int*, double*, Choice> value;
    double min = 0, max = 0;   ///< inclusive range of numbers
    std::vector<int> allowed;  ///< when not empty, the only integers allowed
    std::string unit;          ///< empty for plain numbers
    std::string meaning;       ///< one line
};

/// All fields of `settings`, in the order of the documentation. Pointers live as long as `settings`.
std::vector<Field> fields(Settings& settings);

/// Reads a (partial) JSON tree into `settings`; key "preset" first, if there. `file` and `path` ("settings") place
/// errors: an unknown key (the nearest right key is named), a wrong type or a value out of range throw InputError.
void applyJson(Settings& settings, const nlohmann::json& tree, const std::string& file, const std::string& path);

/// Applies one "key=value" of the command line; "preset=NAME" loads a preset. Throws UsageError.
void applyAssignment(Settings& settings, const std::string& assignment);

/// A preset by name (built in: thesis, fast, balanced, accurate) or by path of a JSON file.
void applyPreset(Settings& settings, const std::string& nameOrFile);
std::vector<std::string> presetNames();

nlohmann::json toJson(const Settings& settings);

/// Table of every key with default, range, unit and meaning, for --help.
std::string describeSettings();

}  // namespace voxcone
