// References in their cache, errors and times of one configuration.
#include "report/evaluate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cli/program.h"
#include "report/sha256.h"
#include "support/gl_context.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;

TEST(Sha256, GivesTheDigestsOfTheStandard) {
    EXPECT_EQ(Sha256().add("abc", 3).hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(Sha256().hex(), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    Sha256 million;
    for (int i = 0; i < 1000; ++i) million.add(std::string(1000, 'a').data(), 1000);
    EXPECT_EQ(million.hex(), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(TimesOf, InterpolatesBetweenRanks) {
    const Times times = timesOf({30, 10, 20});
    EXPECT_DOUBLE_EQ(times.median, 20);
    EXPECT_DOUBLE_EQ(times.p10, 12);
    EXPECT_DOUBLE_EQ(times.p90, 28);
    EXPECT_EQ(times.repeats, (std::vector<double>{30, 10, 20}));
    EXPECT_DOUBLE_EQ(timesOf({7}).p90, 7);
}

class Evaluating : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        script_ = new CaptureScript(loadCaptureScript(VOXCONE_SOURCE_DIR "/assets/captures/cornell.json"));
        for (const char* change : {"output.width=24", "output.height=24", "voxel.resolution=16", "light.bounces=1",
                                   "light.shadow_resolution=128"})
            applyAssignment(script_->settings, change);
        reference_.samples = 16;
    }
    static void TearDownTestSuite() { delete script_; }

    Settings with(const std::string& assignment) const {
        Settings settings = script_->settings;
        applyAssignment(settings, assignment);
        return settings;
    }
    const Shot& shot() const { return script_->shots.front(); }

    static inline CaptureScript* script_ = nullptr;
    static inline Settings::Reference reference_;
    TemporaryFolder cache_;
};

TEST_F(Evaluating, MeasuresTimesErrorsAndCounts) {
    Evaluator evaluator(test::glContext(), *script_, cache_.path(), reference_);
    const Measurement m = evaluator.measure(shot(), script_->settings, 2);
    EXPECT_EQ(m.first.repeats.size(), 2u);
    EXPECT_GT(m.first.median, m.steady.median);
    EXPECT_GT(m.steady.median, 0);
    bool voxelized = false;
    for (const Measurement::Pass& pass : m.passes) {
        if (pass.name == "voxelize: accumulate") voxelized = pass.first && !pass.steady;
        if (pass.name == "cones: diffuse") {
            EXPECT_TRUE(pass.first && pass.steady);
        }
    }
    EXPECT_TRUE(voxelized);
    EXPECT_GT(m.picture.memoryBytes, 100000u);
    EXPECT_GT(m.picture.voxels, 100u);
    // Sixteen cones, each with steps of a voxel at most through sixteen voxels.
    EXPECT_GT(m.picture.samplesPerPixel, 16);
    EXPECT_LT(m.picture.samplesPerPixel, 16 * 100);
    // The Cornell box reflects nothing specularly and has no glass.
    ASSERT_EQ(m.picture.channels.size(), 2u);
    const auto& errors = m.picture.channels.at("indirect_diffuse").errors;
    for (const char* name :
         {"relmse", "rmse", "bias", "relative_bias", "p99", "hdr_flip", "flip", "ssim", "psnr", "grade"})
        EXPECT_TRUE(errors.contains(name) && std::isfinite(errors.at(name))) << name;
    EXPECT_GT(errors.at("relmse"), 0);
    EXPECT_LT(errors.at("relmse"), 1);
}

TEST_F(Evaluating, SamplesAreProportionalToConesAndDoNotChangeThePicture) {
    Evaluator evaluator(test::glContext(), *script_, cache_.path(), reference_);
    const auto trial = [&](const std::string& change) {
        const Settings settings = with(change);
        return Trial(test::glContext(), evaluator.sceneFor(settings), shot(), 0, settings);
    };
    const Reference truth = evaluator.reference(shot(), 0, script_->settings);
    Trial few = trial("cone.diffuse=16"), many = trial("cone.diffuse=32");
    const PictureResult first = few.picture(truth, comparedChannels()), again = few.picture(truth, comparedChannels());
    EXPECT_EQ(first.samplesPerPixel, again.samplesPerPixel);
    EXPECT_EQ(first.channels.at("beauty").errors, again.channels.at("beauty").errors);
    const double ratio = many.picture(truth, comparedChannels()).samplesPerPixel / first.samplesPerPixel;
    EXPECT_NEAR(ratio, 2, 0.3);
}

TEST_F(Evaluating, ReferencesAreRenderedOnceAndKeyedByWhatTheyDependOn) {
    Evaluator evaluator(test::glContext(), *script_, cache_.path(), reference_);
    const Reference made = evaluator.reference(shot(), 0, script_->settings);
    const Reference found = evaluator.reference(shot(), 0, with("preset=fast"));
    EXPECT_EQ(evaluator.referencesRendered(), 1);
    EXPECT_EQ(made.key, found.key);
    EXPECT_EQ(made.samples, found.samples);
    EXPECT_EQ(made.standardErrors, found.standardErrors);
    EXPECT_EQ(made.noise, found.noise);
    EXPECT_GT(made.noise.at("indirect_diffuse"), 0);
    ASSERT_EQ(made.channels.size(), found.channels.size());
    for (const auto& [channel, image] : made.channels) EXPECT_EQ(image.data, found.channels.at(channel).data);

    const auto key = [&](const Settings& settings) { return evaluator.referenceKey(shot(), 0, settings); };
    EXPECT_EQ(key(with("output.exposure=3")), made.key);
    EXPECT_NE(key(with("output.width=25")), made.key);
    EXPECT_NE(key(with("ao.distance=1")), made.key);
    Settings::Reference more = reference_;
    more.samples *= 2;
    EXPECT_NE(Evaluator(test::glContext(), *script_, cache_.path(), more).referenceKey(shot(), 0, script_->settings),
              made.key);
    Shot aside = shot();
    aside.camera.position.x += 0.1;
    EXPECT_NE(evaluator.referenceKey(aside, 0, script_->settings), made.key);
    CaptureScript brighter = *script_;
    brighter.scene.lights.front().intensity *= 2;
    EXPECT_NE(
        Evaluator(test::glContext(), brighter, cache_.path(), reference_).referenceKey(shot(), 0, script_->settings),
        made.key);
}

TEST_F(Evaluating, AReferenceChangesWithEveryFileOfTheScene) {
    const fs::path scenes = VOXCONE_SOURCE_DIR "/assets/scenes", copy = cache_.path() / "scene";
    fs::create_directories(copy);
    for (const char* name : {"cornell.gltf", "cornell.bin"}) fs::copy_file(scenes / name, copy / name);
    const auto key = [&] {
        const CaptureScript script = loadCaptureScript(copy / "cornell.gltf");
        return Evaluator(test::glContext(), script, cache_.path(), reference_)
            .referenceKey(script.shots.front(), 0, script_->settings);
    };
    const std::string before = key();
    EXPECT_EQ(key(), before);
    std::string bytes = contentOf(copy / "cornell.bin");
    bytes.back() = static_cast<char>(bytes.back() ^ 1);
    std::ofstream(copy / "cornell.bin", std::ios::binary) << bytes;
    EXPECT_NE(key(), before);
}

TEST_F(Evaluating, VoxelAmbientOcclusionDarkensIndirectLight) {
    Evaluator evaluator(test::glContext(), *script_, cache_.path(), reference_);
    const Reference truth = evaluator.reference(shot(), 0, script_->settings);
    Trial trial(test::glContext(), evaluator.sceneFor(script_->settings), shot(), 0, script_->settings);
    const PictureResult plain = trial.picture(truth, comparedChannels()),
                        occluded = trial.picture(truth, comparedChannels(), true);
    EXPECT_LT(occluded.channels.at("indirect_diffuse").errors.at("bias"),
              plain.channels.at("indirect_diffuse").errors.at("bias"));
    // Beauty loses 2^exposure times what the channel loses.
    const auto loss = [&](const char* channel) {
        return plain.channels.at(channel).errors.at("bias") - occluded.channels.at(channel).errors.at("bias");
    };
    EXPECT_NEAR(loss("beauty") / loss("indirect_diffuse"), std::exp2(script_->settings.output.exposure), 1e-3);
}

}  // namespace
}  // namespace voxcone
