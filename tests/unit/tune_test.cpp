// The settings that voxcone tune chooses from.
#include "report/tune.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/atomic_file.h"
#include "core/error.h"

namespace voxcone {
namespace {

using nlohmann::json;
using testing::HasSubstr;

const Knob* knobOf(const TuneSpace& space, const std::string& key) {
    for (const Knob& knob : space.knobs)
        if (knob.key == key) return &knob;
    return nullptr;
}

TEST(TuneSpace, DefaultsHoldTheScriptsOwnValuesInOrder) {
    Settings base;
    base.cone.step = 1.25;
    base.light.bounces = 5;
    const TuneSpace space = defaultTuneSpace(base, "beauty");
    EXPECT_EQ(knobOf(space, "cone.step")->values, (std::vector<json>{2.0, 1.5, 1.25, 1.0, 0.7}));
    EXPECT_EQ(knobOf(space, "light.bounces")->values, (std::vector<json>{0, 1, 2, 3, 5, 6}));
    EXPECT_EQ(toJson(space.settingsOf(space.nearest(base))), toJson(base));
    EXPECT_EQ(space.changesOf(space.nearest(base)), "-");
}

TEST(TuneSpace, EveryChoiceIsValid) {
    const TuneSpace space = defaultTuneSpace(Settings{}, "beauty");
    Choice lowest(space.knobs.size(), 0);
    for (std::size_t k = 0; k < space.knobs.size(); ++k) {
        for (std::size_t i = 0; i < space.knobs[k].values.size(); ++i) {
            Choice choice = lowest;
            choice[k] = static_cast<int>(i);
            EXPECT_NO_THROW(space.settingsOf(choice));
        }
    }
}

TEST(TuneSpace, LeavesOutWhatCannotMatter) {
    EXPECT_TRUE(knobOf(defaultTuneSpace({}, "beauty"), "specular.cones"));
    EXPECT_FALSE(knobOf(defaultTuneSpace({}, "indirect_diffuse"), "specular.cones"));
    EXPECT_FALSE(knobOf(defaultTuneSpace({}, "indirect_specular"), "cone.diffuse"));
    Settings thesis;
    applyPreset(thesis, "thesis");
    EXPECT_FALSE(knobOf(defaultTuneSpace(thesis, "beauty"), "cone.near_field"));
    EXPECT_FALSE(knobOf(defaultTuneSpace(thesis, "beauty"), "cone.footprint_cap"));
}

TEST(TuneSpace, SearchBeginsWithTheScriptAndFast) {
    Settings base;
    base.voxel.resolution = 64;
    const TuneSpace space = defaultTuneSpace(base, "beauty");
    const SearchSpace search = space.searchSpace(true);
    EXPECT_TRUE(search.smallPictures);
    ASSERT_EQ(search.seeds.size(), 2u);
    EXPECT_EQ(toJson(space.settingsOf(search.seeds[0])), toJson(base));
    // The preset says nothing of the resolution, which stays.
    const Settings fast = space.settingsOf(search.seeds[1]);
    EXPECT_EQ(fast.voxel.resolution, 64);
    EXPECT_EQ(fast.cone.diffuse, 6);
    EXPECT_EQ(fast.cone.nearField, 8);
}

TEST(TuneSpace, SettingsWithoutEffectMakeOneChoice) {
    TuneSpace space;
    for (const char* text :
         {"voxel.storage=isotropic,six_face", "cone.near_field=0,8", "light.bounces=0,2", "light.bounce_cones=5,16"})
        space.knobs.push_back(knobFromText(text));
    const SearchSpace search = space.searchSpace(false);
    EXPECT_EQ(search.canonicalOf({0, 1, 1, 1}), (Choice{0, 0, 1, 1}));
    EXPECT_EQ(search.canonicalOf({1, 1, 0, 1}), (Choice{1, 1, 0, 0}));
    EXPECT_EQ(search.canonicalOf({1, 1, 1, 1}), (Choice{1, 1, 1, 1}));

    space.base.voxel.storage = VoxelStorage::sh1;
    space.knobs = {knobFromText("cone.near_field=0,8")};
    EXPECT_EQ(space.searchSpace(false).canonicalOf({1}), (Choice{0}));
}

TEST(Knobs, FromText) {
    const Knob knob = knobFromText("voxel.storage=isotropic,six_face");
    EXPECT_EQ(knob.key, "voxel.storage");
    EXPECT_EQ(knob.values, (std::vector<json>{"isotropic", "six_face"}));
    EXPECT_EQ(knobFromText("cone.step=2,0.5").values, (std::vector<json>{2.0, 0.5}));
    const auto reason = [](const char* text) -> std::string {
        try {
            knobFromText(text);
        } catch (const UsageError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_THAT(reason("cone.diffuse"), HasSubstr("expected KEY=VALUE,VALUE"));
    EXPECT_THAT(reason("cone.difuse=5,6"), HasSubstr("did you mean \"cone.diffuse\""));
    EXPECT_THAT(reason("cone.diffuse=5,7"), HasSubstr("7 is not a value of cone.diffuse"));
    EXPECT_THAT(reason("cone.diffuse=5"), HasSubstr("fewer than two"));
    EXPECT_THAT(reason("preset=fast,accurate"), HasSubstr("preset"));
}

TEST(Preset, GivesTheSettingsWhateverItIsAppliedTo) {
    Settings tuned;
    applyPreset(tuned, "fast");
    tuned.voxel.resolution = 32;
    tuned.cascade.levels = 2;
    tuned.output.width = 77;
    const json preset = presetOf(tuned);
    EXPECT_FALSE(preset.contains("output"));
    EXPECT_FALSE(preset.contains("reference"));
    const auto file = std::filesystem::temp_directory_path() / "voxcone_tune_test_preset.json";
    writeTextFile(file, preset.dump());
    Settings other;
    applyPreset(other, "thesis");
    other.output.width = 99;
    applyPreset(other, file.string());
    std::filesystem::remove(file);
    EXPECT_EQ(presetOf(other), preset);
    EXPECT_EQ(other.output.width, 99);
}

}  // namespace
}  // namespace voxcone
