// The settings tree by JSON, by key=value and by preset.
#include "core/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"

namespace voxcone {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

template <class E, class F>
std::string messageOf(F&& f) {
    try {
        f();
    } catch (const E& error) {
        return error.what();
    }
    return "(no error)";
}

std::string jsonError(const char* text) {
    Settings settings;
    return messageOf<InputError>([&] { applyJson(settings, json::parse(text), "s.json", "settings"); });
}

std::string assignmentError(const char* assignment) {
    Settings settings;
    return messageOf<UsageError>([&] { applyAssignment(settings, assignment); });
}

TEST(Settings, EveryDefaultIsInsideItsRangeAndSurvivesJson) {
    Settings settings, back;
    back.output.width = 1, back.cone.diffuse = 1, back.voxel.conservative = false,
    back.output.toneMap = ToneMap::linear;
    applyJson(back, toJson(settings), "s.json", "settings");  // refuses what is out of range
    EXPECT_EQ(toJson(back), toJson(settings));
}

TEST(Settings, KeysAreUniqueAndDescribed) {
    Settings settings;
    std::set<std::string> keys;
    for (const Field& field : fields(settings)) {
        EXPECT_TRUE(keys.insert(field.key).second) << field.key;
        EXPECT_FALSE(field.meaning.empty()) << field.key;
        EXPECT_THAT(describeSettings(), HasSubstr(field.key));
    }
}

TEST(Settings, PartialTreeChangesOnlyWhatItNames) {
    Settings settings;
    applyJson(settings, json::parse(R"({"cone": {"diffuse": 6, "compositing": "exponential"}})"), "s.json", "settings");
    EXPECT_EQ(settings.cone.diffuse, 6);
    EXPECT_EQ(settings.cone.compositing, Compositing::exponential);
    Settings expected;
    expected.cone.diffuse = 6, expected.cone.compositing = Compositing::exponential;
    EXPECT_EQ(toJson(settings), toJson(expected));
}

TEST(Settings, JsonErrorsNameFilePathAndWhatIsRight) {
    EXPECT_THAT(jsonError(R"({"cone": {"difuse": 6}})"),
                AllOf(HasSubstr("s.json: settings.cone.difuse: "), HasSubstr("did you mean \"cone.diffuse\"")));
    EXPECT_THAT(jsonError(R"({"cone": {"diffuse": 7}})"),
                AllOf(HasSubstr("settings.cone.diffuse"), HasSubstr("1, 5, 6, 9, 16, 32")));
    EXPECT_THAT(jsonError(R"({"cone": {"diffuse": "six"}})"), HasSubstr("settings.cone.diffuse"));
    EXPECT_THAT(jsonError(R"({"output": {"width": 0}})"),
                AllOf(HasSubstr("settings.output.width"), HasSubstr("1 to 16384")));
    EXPECT_THAT(jsonError(R"({"output": {"width": 10.5}})"), HasSubstr("settings.output.width"));
    EXPECT_THAT(jsonError(R"({"output": {"width": 1e300}})"), HasSubstr("settings.output.width"));
    EXPECT_THAT(jsonError(R"({"voxel": {"conservative": 1}})"), HasSubstr("true or false"));
    EXPECT_THAT(jsonError(R"({"cone": 3})"), HasSubstr("settings.cone: must be an object"));
    EXPECT_THAT(jsonError("[]"), HasSubstr("settings: must be an object"));
    EXPECT_THAT(jsonError(R"({"preset": "fastest"})"), AllOf(HasSubstr("settings.preset"), HasSubstr("balanced")));
}

TEST(Settings, AssignmentsOfEveryKind) {
    Settings settings;
    applyAssignment(settings, "voxel.resolution=64");
    applyAssignment(settings, "cone.gain=1.5");
    applyAssignment(settings, "cone.rotate=false");
    applyAssignment(settings, "output.tone_map=linear");
    EXPECT_EQ(settings.voxel.resolution, 64);
    EXPECT_EQ(settings.cone.gain, 1.5);
    EXPECT_FALSE(settings.cone.rotate);
    EXPECT_EQ(settings.output.toneMap, ToneMap::linear);
}

TEST(Settings, WrongAssignmentsSayTheRightUsage) {
    EXPECT_THAT(assignmentError("cone.gain"), HasSubstr("key=value"));
    EXPECT_THAT(assignmentError("=3"), HasSubstr("key=value"));
    EXPECT_THAT(assignmentError("voxel.resolutoin=64"), HasSubstr("voxel.resolution"));
    EXPECT_THAT(assignmentError("voxel.resolution=65"), HasSubstr("16, 32, 64, 128, 256"));
    EXPECT_THAT(assignmentError("cone.gain=nan"), HasSubstr("cone.gain"));
    EXPECT_THAT(assignmentError("output.tone_map=filmic"), HasSubstr("reinhard"));
    EXPECT_THAT(assignmentError("preset=none"), HasSubstr("thesis"));
}

TEST(Settings, PresetsSetTheMethodAndLeaveThePicture) {
    for (const std::string& name : presetNames()) {
        Settings settings;
        settings.output.width = 99, settings.reference.samples = 3;
        settings.cone.gain = 7;  // a leftover of other settings must not survive
        applyAssignment(settings, "preset=" + name);
        EXPECT_EQ(settings.output.width, 99) << name;
        EXPECT_EQ(settings.reference.samples, 3) << name;
        EXPECT_NE(settings.cone.gain, 7) << name;
    }
    Settings balanced;
    applyPreset(balanced, "balanced");
    EXPECT_EQ(toJson(balanced), toJson(Settings{}));
    Settings thesis;
    applyPreset(thesis, "thesis");
    EXPECT_EQ(thesis.voxel.storage, VoxelStorage::isotropic);
    EXPECT_EQ(thesis.cone.diffuse, 9);
    EXPECT_EQ(thesis.cone.start, StartOffset::nudge);
}

TEST(Settings, PresetOfAJsonTreeComesFirstWhereverItStands) {
    Settings settings;
    applyJson(settings, json::parse(R"({"cone": {"diffuse": 32}, "preset": "thesis"})"), "s.json", "settings");
    EXPECT_EQ(settings.cone.diffuse, 32);
    EXPECT_EQ(settings.voxel.storage, VoxelStorage::isotropic);
}

TEST(Settings, PresetFilesAreRelativeToTheFileThatNamesThem) {
    const auto folder = std::filesystem::temp_directory_path() / ("voxcone_preset_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "mine.json") << R"({"preset": "fast", "cone": {"gain": 2}})";
    std::ofstream(folder / "broken.json") << "{";
    const std::string script = (folder / "s.json").string();
    Settings settings;
    applyJson(settings, json::parse(R"({"preset": "mine.json"})"), script, "settings");
    EXPECT_EQ(settings.cone.gain, 2);
    EXPECT_EQ(settings.cone.diffuse, 6);
    EXPECT_THAT(messageOf<InputError>([&] { applyPreset(settings, (folder / "broken.json").string()); }),
                AllOf(HasSubstr("broken.json"), HasSubstr("not valid JSON")));
    EXPECT_THAT(messageOf<InputError>([&] { applyPreset(settings, (folder / "none.json").string()); }),
                HasSubstr("none.json"));
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace voxcone
