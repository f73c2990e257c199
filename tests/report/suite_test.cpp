// Suites: what they expand to, how they are cut into parts, and what is said about mistakes.
#include "report/suite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "cli/program.h"
#include "core/atomic_file.h"
#include "core/error.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kAssets = VOXCONE_SOURCE_DIR "/assets/";

class Suites : public testing::Test {
  protected:
    /// A suite of `views` and `configurations`, which are JSON.
    Suite load(const std::string& views, const std::string& configurations, const std::string& more = "") {
        const fs::path file = folder_.path() / "suite.json";
        writeTextFile(file, R"({"version": 1, "name": "s", )" + more + R"("views": [)" + views +
                                R"(], "configurations": [)" + configurations + "]}");
        return loadSuite(file);
    }
    static std::string view(const std::string& scene, const std::string& more = "") {
        return R"({"scene": ")" + scene + R"(", "script": ")" + kAssets + "captures/" + scene + R"(.json")" + more +
               "}";
    }
    std::string messageOf(const std::string& views, const std::string& configurations, const std::string& more = "") {
        try {
            load(views, configurations, more);
        } catch (const Error& error) {
            return error.what();
        }
        return "no error";
    }
    static std::vector<std::string> idsOf(const Suite& suite) {
        std::vector<std::string> ids;
        for (const SuiteConfiguration& c : suite.configurations) ids.push_back(c.id);
        return ids;
    }

    TemporaryFolder folder_;
};

TEST_F(Suites, GridsAndListsBecomeConfigurations) {
    const Suite suite = load(view("cornell"), R"(
        {"id": "plain"},
        {"id": "cones", "preset": "fast", "grid": {"cone.step": [1, 2], "cone.diffuse": [5, 9]}},
        {"list": [{"voxel.resolution": 32, "light.bounces": 0}, {"preset": "thesis"}]})");
    EXPECT_THAT(idsOf(suite),
                ElementsAre("plain", "cones cone.diffuse=5 cone.step=1", "cones cone.diffuse=5 cone.step=2",
                            "cones cone.diffuse=9 cone.step=1", "cones cone.diffuse=9 cone.step=2",
                            "light.bounces=0 voxel.resolution=32", "preset=thesis"));
    const auto settings = [&](std::size_t i) { return suite.settingsOf(suite.views[0], suite.configurations[i]); };
    EXPECT_EQ(settings(3).cone.diffuse, 9);
    EXPECT_EQ(settings(3).light.bounces, 2);  // of fast
    EXPECT_EQ(settings(5).voxel.resolution, 32);
    EXPECT_EQ(settings(6).voxel.storage, VoxelStorage::isotropic);
    EXPECT_EQ(settings(6).output.width, 512);  // of the script
}

TEST_F(Suites, LaterLayersOfSettingsWin) {
    const Suite suite =
        load(view("cornell", R"(, "settings": {"cone": {"step": 3, "gain": 2}}, "reference": {"samples": 8})"),
             R"({"id": "a", "preset": "fast", "settings": {"cone": {"gain": 3}}})",
             R"("settings": {"cone": {"step": 2, "diffuse": 9}}, "reference": {"samples": 4, "max_depth": 5}, )");
    const Settings settings = suite.settingsOf(suite.views[0], suite.configurations[0]);
    EXPECT_EQ(settings.light.bounces, 2);
    EXPECT_EQ(settings.cone.diffuse, 9);
    EXPECT_EQ(settings.cone.step, 3);
    EXPECT_EQ(settings.cone.gain, 3);
    EXPECT_EQ(settings.reference.samples, 8);
    EXPECT_EQ(settings.reference.maxDepth, 5);
    EXPECT_EQ(suite.configurations[0].set, (nlohmann::json{{"cone.gain", 3}}));
}

TEST_F(Suites, ViewsAreShotsCamerasAndFrames) {
    const Suite suite =
        load(view("basic", R"(, "shots": ["view2"])") + "," + view("spheres", R"(, "frames": [0, 7])") + "," +
                 view("cornell", R"(, "cameras": [{"name": "low", "position": [0, 1, 5], "target": [0, 1, 0]}])"),
             R"({"id": "a"}, {"id": "b", "scenes": ["basic", "cornell"]})");
    std::vector<std::string> ids;
    for (const SuiteView& v : suite.views) ids.push_back(v.id);
    EXPECT_THAT(ids, ElementsAre("basic/view2", "spheres/roughness", "spheres/roughness@7", "cornell/low"));
    EXPECT_EQ(rowsOf(suite).size(), 4u + 2u);
}

TEST_F(Suites, EveryRowIsInOnePart) {
    const std::string configurations = R"({"id": "a"}, {"id": "b"}, {"id": "c", "scenes": ["basic"]})";
    const Suite suite = load(view("basic") + "," + view("cornell"), configurations);
    const std::vector<SuiteRow> all = rowsOf(suite);
    ASSERT_EQ(suite.views.size(), 3u);
    for (int parts = 1; parts <= 12; ++parts) {
        std::vector<SuiteRow> joined;
        for (int part = 1; part <= parts; ++part) {
            const std::vector<SuiteRow> rows = rowsOf(suite, {part, parts});
            joined.insert(joined.end(), rows.begin(), rows.end());
            // As long as there are views enough, no view is cut.
            if (parts > 3) continue;
            std::set<std::size_t> views;
            for (const SuiteRow& row : rows) views.insert(row.view);
            std::size_t whole = 0;
            for (const SuiteRow& row : all) whole += views.contains(row.view);
            EXPECT_EQ(rows.size(), whole) << part << "/" << parts;
        }
        EXPECT_EQ(joined, all) << parts;
    }
}

TEST_F(Suites, MistakesAreToldWithTheirPlace) {
    const std::string a = R"({"id": "a"})", cornell = view("cornell");
    EXPECT_THAT(messageOf(cornell, R"({"id": "a", "grids": {}})"),
                AllOf(HasSubstr("suite.json: configurations[0].grids: unknown key"), HasSubstr("\"grid\"")));
    EXPECT_THAT(messageOf(cornell, R"({"grid": {"cone.difuse": [5]}})"),
                AllOf(HasSubstr("configurations[0].grid"), HasSubstr("\"cone.diffuse\"")));
    EXPECT_THAT(messageOf(cornell, R"({"grid": {"cone.diffuse": [5, 7]}})"),
                HasSubstr("configurations[0].grid.cone.diffuse: 7 is not a value of cone.diffuse"));
    EXPECT_THAT(messageOf(cornell, R"({"grid": {"cone.diffuse": 5}})"),
                HasSubstr("configurations[0].grid.cone.diffuse: must be an array"));
    EXPECT_THAT(messageOf(cornell, R"({"list": [{"preset": "fats"}]})"),
                HasSubstr("configurations[0].list[0].preset: unknown preset \"fats\""));
    EXPECT_THAT(messageOf(cornell, a + "," + a),
                HasSubstr("configurations[1]: configuration \"a\" stands there twice"));
    EXPECT_THAT(messageOf(cornell, R"({"preset": "fast"})"), HasSubstr("configurations[0].id: is missing"));
    EXPECT_THAT(messageOf(cornell, R"({"id": "a", "scenes": ["basic"]})"),
                HasSubstr("configurations[0].scenes: \"basic\" is no scene of the suite"));
    EXPECT_THAT(messageOf(cornell, R"({"id": "a", "settings": {"reference": {"samples": 5}}})"),
                HasSubstr("configurations[0].settings.reference: belongs to the key reference"));
    EXPECT_THAT(messageOf(cornell, a, R"("settings": {"preset": "fast"}, )"),
                HasSubstr("settings.preset: belongs to a configuration"));
    EXPECT_THAT(messageOf(view("cornell", R"(, "shots": ["back"])"), a),
                HasSubstr("views[0].shots[0]: \"back\" is no shot of"));
    EXPECT_THAT(messageOf(cornell + "," + cornell, a),
                HasSubstr("views[1].scene: \"cornell\" is another scene's name"));
    EXPECT_THAT(messageOf(R"({"scene": "x", "script": "nowhere.json"})", a),
                HasSubstr("views[0].script: no such file"));
    EXPECT_THAT(messageOf(cornell, a, R"("reference": {"samples": 1}, )"),
                HasSubstr("reference.samples: 1 is out of range"));
    EXPECT_THAT(messageOf(cornell, a, R"("channels": ["depth"], )"),
                HasSubstr("channels[0]: \"depth\" cannot be compared"));
}

TEST_F(Suites, OptionalScenesThatAreMissingAreLeftOut) {
    writeTextFile(folder_.path() / "script.json",
                  R"({"version": 1, "scene": "nowhere.gltf", "shots": [
                      {"name": "a", "camera": {"position": [0, 1, 5], "target": [0, 1, 0]}, "channels": ["beauty"]}]})");
    const std::string hall =
        R"({"scene": "hall", "script": "script.json", "optional": true, "reference": {"samples": 4}})";
    EXPECT_EQ(load(hall + "," + view("cornell"), R"({"id": "a"}, {"id": "b", "scenes": ["hall"]})").views.size(), 1u);
    EXPECT_THAT(messageOf(hall, R"({"id": "a"})"), HasSubstr("views: no scene is left"));
    // Given by the user.
    const Suite given = loadSuite(folder_.path() / "suite.json", {{"hall", kAssets + "scenes/cornell.gltf"}});
    ASSERT_EQ(given.views.size(), 1u);
    EXPECT_EQ(given.views[0].id, "hall/a");
    EXPECT_GT(given.scripts[0]->scene.triangleCount(), 0u);
    EXPECT_THROW(loadSuite(folder_.path() / "suite.json", {{"hal", kAssets + "scenes/cornell.gltf"}}), UsageError);
}

TEST(SuitesOfTheTree, CanBeRead) {
    for (const char* name : {"quick", "thesis", "full"}) {
        const Suite suite = loadSuite(kAssets + "suites/" + name + ".json");
        EXPECT_EQ(suite.name, name);
        EXPECT_GT(rowsOf(suite).size(), 10u) << name;
        for (const SuiteRow& row : rowsOf(suite))
            suite.settingsOf(suite.views[row.view], suite.configurations[row.configuration]);
    }
}

}  // namespace
}  // namespace voxcone
