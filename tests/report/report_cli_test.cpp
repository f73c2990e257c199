// voxcone report as a user runs it, on pictures of 24 pixels: whole, again, stopped, cut into parts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "cli/program.h"
#include "core/atomic_file.h"
#include "metric/image.h"

namespace voxcone {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

const std::string kCaptures = VOXCONE_SOURCE_DIR "/assets/captures/";

/// Two views, two configurations that work; `more` are further ones.
std::string suiteText(int repeats, const std::string& more = "") {
    return R"({"version": 1, "name": "tiny", "reference": {"samples": 8}, "repeats": )" + std::to_string(repeats) +
           R"(, "settings": {"output": {"width": 24, "height": 24}, "voxel": {"resolution": 16},
                             "light": {"shadow_resolution": 128}},
               "views": [{"scene": "cornell", "script": ")" +
           kCaptures + R"(cornell.json"}, {"scene": "basic", "script": ")" + kCaptures +
           R"(basic.json", "shots": ["view2"]}],
               "configurations": [{"id": "quick", "preset": "fast"},
                                  {"preset": "balanced", "grid": {"cone.diffuse": [5]}})" +
           more + "]}";
}

/// No device has a texture for so wide a picture.
const std::string kBroken =
    R"(, {"id": "broken", "scenes": ["cornell"],
          "settings": {"output": {"width": 16384, "height": 1, "supersample": 8}}})";

std::map<std::string, fs::file_time_type> timesOf(const fs::path& folder) {
    std::map<std::string, fs::file_time_type> times;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (entry.is_regular_file())
            times[entry.path().lexically_relative(folder).string()] = fs::last_write_time(entry.path());
    }
    return times;
}

json reportOf(const fs::path& folder) {
    return json::parse(contentOf(folder / "report.json"));
}

/// Without what two runs of the same suite differ in: times and the command that names the folder.
json withoutTimes(json report) {
    for (const char* key : {"times_made", "command"}) report.erase(key);
    for (json& view : report["views"])
        if (view.contains("reference")) view["reference"].erase("seconds");
    for (json& row : report["rows"]) {
        row.erase("ms");
        if (row.contains("reference")) row["reference"].erase("seconds");
        json passes = json::array();
        for (const json& pass : row.value("passes", json::array()))
            passes.push_back({pass["name"], pass["first"].is_null(), pass["steady"].is_null()});
        row["passes"] = passes;
    }
    return report;
}

class Reports : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        folder_ = new TemporaryFolder;
        writeTextFile(suite(), suiteText(2, kBroken));
        first_ = voxcone({"report", suite(), "--out", out().string()});
    }
    static void TearDownTestSuite() { delete folder_; }
    static std::string suite() { return (folder_->path() / "suite.json").string(); }
    static fs::path out() { return folder_->path() / "out"; }

    static inline TemporaryFolder* folder_ = nullptr;
    static inline Outcome first_;
};

TEST_F(Reports, HaveARowForEveryViewAndConfiguration) {
    ASSERT_EQ(first_.status, 0) << first_.err;
    for (const char* name : {"report.json", "report.csv", "index.html"})
        EXPECT_THAT(first_.out, HasSubstr((out() / name).string() + "\n"));
    const json report = reportOf(out());
    EXPECT_EQ(report["views"].size(), 2u);
    EXPECT_EQ(report["configurations"].size(), 3u);
    ASSERT_EQ(report["rows"].size(), 5u);
    for (const json& row : report["rows"]) {
        if (row["configuration"] == "broken") continue;
        EXPECT_EQ(row["status"], "ok") << row;
        EXPECT_EQ(row["ms"]["first"]["repeats"].size(), 2u);
        EXPECT_GT(row["ms"]["first"]["median"].get<double>(), row["ms"]["steady"]["median"].get<double>());
        EXPECT_LE(row["ms"]["steady"]["p10"].get<double>(), row["ms"]["steady"]["p90"].get<double>());
        double passes = 0;
        for (const json& pass : row["passes"])
            if (!pass["first"].is_null()) passes += pass["first"]["median"].get<double>();
        EXPECT_NEAR(passes / row["ms"]["first"]["median"].get<double>(), 1, 0.3);
        EXPECT_GT(row["memory_bytes"].get<double>(), 0);
        EXPECT_GT(row["samples_per_pixel"].get<double>(), 5);
        EXPECT_GT(row["errors"]["beauty"]["relmse"].get<double>(), 0);
        for (const auto& [name, path] : row["images"].items()) {
            const Image image = readImage(out() / path.get<std::string>());
            EXPECT_EQ(image.width, 24) << name;
        }
    }
    for (const json& view : report["views"]) {
        EXPECT_EQ(view["reference"]["samples"], 8);
        EXPECT_GT(view["reference"]["standard_error"]["indirect_diffuse"].get<double>(), 0);
        EXPECT_GT(view["reference"]["noise_relmse"]["indirect_diffuse"].get<double>(), 0);
        EXPECT_EQ(readImage(out() / view["reference"]["images"]["beauty"].get<std::string>()).width, 24);
    }
    EXPECT_EQ(report["configurations"][1]["set"], (json{{"cone.diffuse", 5}}));
    EXPECT_EQ(report["configurations"][0]["settings"]["cone"]["diffuse"], 6);
    const std::string csv = contentOf(out() / "report.csv");
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 6);
    EXPECT_THAT(csv, AllOf(HasSubstr("cornell/front,quick,ok,,"), HasSubstr("indirect_diffuse.relmse"),
                           HasSubstr("first_ms: voxelize: accumulate")));
}

TEST_F(Reports, TellWhatFailedAndGoOn) {
    const json row = reportOf(out())["rows"][2];
    EXPECT_EQ(row["configuration"], "broken");
    EXPECT_EQ(row["status"], "failed");
    EXPECT_THAT(row["reason"].get<std::string>(), HasSubstr("GL_MAX_TEXTURE_SIZE"));
    EXPECT_THAT(first_.err, HasSubstr("failed: cornell/front, broken: a texture of size"));
}

TEST_F(Reports, RenderNothingWhenTheyAreFinished) {
    const auto before = timesOf(out());
    const Outcome again = voxcone({"report", suite(), "--out", out().string()});
    ASSERT_EQ(again.status, 0) << again.err;
    EXPECT_EQ(timesOf(out()), before);
}

// Errors are those that capture, reference and compare give.
TEST_F(Reports, ErrorsAreThoseOfCompare) {
    const TemporaryFolder folder;
    const std::vector<std::string> settings = {"--set", "preset=fast",
                                               "--set", "output.width=24",
                                               "--set", "output.height=24",
                                               "--set", "voxel.resolution=16",
                                               "--set", "light.shadow_resolution=128",
                                               "--set", "reference.samples=8"};
    for (const char* command : {"capture", "reference"}) {
        std::vector<std::string> arguments = {command, kCaptures + "cornell.json", "--out",
                                              (folder.path() / command).string()};
        arguments.insert(arguments.end(), settings.begin(), settings.end());
        ASSERT_EQ(voxcone(arguments).status, 0);
    }
    const Outcome compared =
        voxcone({"compare", (folder.path() / "reference").string(), (folder.path() / "capture").string(), "--json"});
    const json row = reportOf(out())["rows"][0];
    int seen = 0;
    const json pairs = json::parse(compared.out)["pairs"];
    for (const json& pair : pairs) {
        const auto name = pair["name"].get<std::string>();
        const std::string channel = name.substr(6, name.find(".0000") - 6);
        if (!row["errors"].contains(channel)) continue;
        ++seen;
        // Pictures are read back from files there. The grade is a thousandth power, which multiplies what rounding
        // leaves.
        for (const auto& [metric, value] : pair["metrics"].items())
            EXPECT_NEAR(row["errors"][channel][metric].get<double>(), value.get<double>(),
                        (metric == "grade" ? 1e-2 : 1e-5) * std::abs(value.get<double>()))
                << channel << " " << metric;
    }
    EXPECT_EQ(seen, 2);
}

/// The program at work on a suite.
pid_t startReport(const fs::path& file, const fs::path& to) {
    const pid_t child = fork();
    if (child == 0) {
        execl(VOXCONE_PROGRAM, VOXCONE_PROGRAM, "report", file.c_str(), "--out", to.c_str(), nullptr);
        _exit(127);
    }
    return child;
}

TEST_F(Reports, GoOnWhereTheyWereStopped) {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "suite.json", to = folder.path() / "out";
    writeTextFile(file, suiteText(10));
    const pid_t child = startReport(file, to);
    const auto repeats = [&] {
        std::map<std::string, fs::file_time_type> found;
        if (!fs::exists(to / "measurements")) return found;
        for (const auto& [name, time] : timesOf(to))
            if (name.find("/repeat.") != std::string::npos) found[name] = time;
        return found;
    };
    for (int i = 0; i < 6000 && repeats().size() < 3; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    kill(child, SIGINT);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    ASSERT_EQ(WEXITSTATUS(status), 128 + SIGINT);
    EXPECT_FALSE(fs::exists(to / "report.json"));
    const auto before = repeats();
    ASSERT_GE(before.size(), 3u);
    for (const auto& [name, time] : timesOf(to))
        EXPECT_EQ(fs::path(name).filename().string().find(".part"), std::string::npos) << name;

    ASSERT_EQ(voxcone({"report", file.string(), "--out", to.string()}).status, 0);
    const auto after = repeats();
    EXPECT_EQ(after.size(), 2u * 2u * 10u);
    for (const auto& [name, time] : before) EXPECT_EQ(after.at(name), time) << name;
    const json report = reportOf(to);
    for (const json& row : report["rows"]) EXPECT_EQ(row["status"], "ok");
}

// A driver that crashes, or the kernel when no memory is left, ends the program like this.
TEST_F(Reports, TellWhatTheyWereKilledIn) {
    const TemporaryFolder folder;
    const fs::path file = folder.path() / "suite.json", to = folder.path() / "out";
    writeTextFile(file, suiteText(2));
    const pid_t child = startReport(file, to);
    fs::path marked;
    for (int i = 0; i < 6000 && marked.empty(); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        kill(child, SIGSTOP);
        int status = 0;
        ASSERT_EQ(waitpid(child, &status, WUNTRACED), child);
        ASSERT_TRUE(WIFSTOPPED(status)) << "it has ended before";
        if (fs::exists(to))
            for (const auto& entry : fs::recursive_directory_iterator(to))
                if (entry.path().filename() == "measuring") marked = entry.path().parent_path();
        if (marked.empty()) kill(child, SIGCONT);
    }
    ASSERT_FALSE(marked.empty());
    kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);

    const Outcome again = voxcone({"report", file.string(), "--out", to.string()});
    ASSERT_EQ(again.status, 0) << again.err;
    EXPECT_THAT(again.err, HasSubstr("ended while it measured this"));
    int failed = 0;
    const json report = reportOf(to);
    for (const json& row : report["rows"]) {
        if (row["status"] == "ok") continue;
        ++failed;
        EXPECT_EQ(row["status"], "failed");
        EXPECT_THAT(row["reason"].get<std::string>(), HasSubstr("ended while it measured this"));
    }
    EXPECT_EQ(failed, 1);
    EXPECT_TRUE(fs::exists(marked / "failed.json"));
    EXPECT_FALSE(fs::exists(marked / "measuring"));
}

// As docs/reports.md has it.
TEST_F(Reports, PartsUnderGnuParallelMergeToTheWhole) {
    const TemporaryFolder folder;
    const std::string line = "parallel --will-cite -j2 \"'" VOXCONE_PROGRAM "' report '" + suite() + "' --out '" +
                             folder.path().string() + "/part{}' --shard {}/2\" ::: 1 2 >/dev/null 2>&1 </dev/null";
    ASSERT_EQ(std::system(line.c_str()), 0) << "GNU parallel";
    const fs::path one = folder.path() / "part1", two = folder.path() / "part2", merged = folder.path() / "merged";
    const json part = reportOf(one);
    EXPECT_EQ(part["rows"].size(), 5u);
    EXPECT_EQ(part["rows"][0]["status"], "ok");
    EXPECT_EQ(part["rows"][4]["status"], "missing");

    const Outcome outcome = voxcone({"report", "merge", one.string(), two.string(), "--out", merged.string()});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(withoutTimes(reportOf(merged)), withoutTimes(reportOf(out())));
    for (const auto& [name, time] : timesOf(out() / "images"))
        EXPECT_EQ(contentOf(merged / "images" / name), contentOf(out() / "images" / name)) << name;
    EXPECT_TRUE(fs::exists(merged / "index.html"));

    const Outcome half = voxcone({"report", "merge", one.string(), "--out", (folder.path() / "half").string()});
    EXPECT_EQ(half.status, 0);
    EXPECT_THAT(half.err, HasSubstr("2 rows are missing"));
}

TEST_F(Reports, OfOtherSuitesDoNotMerge) {
    const TemporaryFolder folder;
    json other = reportOf(out());
    other["suite"]["hash"] = "another";
    writeTextFile(folder.path() / "report.json", other.dump());
    const Outcome outcome = voxcone(
        {"report", "merge", out().string(), folder.path().string(), "--out", (folder.path() / "merged").string()});
    EXPECT_EQ(outcome.status, 3);
    EXPECT_THAT(outcome.err, HasSubstr("is another suite than that of"));
}

TEST_F(Reports, WrongUsageIsTold) {
    const auto status = [&](const std::vector<std::string>& arguments) { return voxcone(arguments).status; };
    EXPECT_EQ(status({"report", suite()}), 2);
    for (const char* shard : {"3/2", "1/2x"})
        EXPECT_EQ(status({"report", suite(), "--out", "x", "--shard", shard}), 2) << shard;
    EXPECT_EQ(status({"report", suite(), "--out", "x", "--scene", "cornell"}), 2);
    EXPECT_EQ(status({"report", suite(), "--out", "x", "--scene", "nowhere=a.gltf"}), 2);
    EXPECT_EQ(status({"report", "merge", "--out", "x"}), 2);
    EXPECT_EQ(status({"report", "nowhere.json", "--out", "x"}), 3);
    EXPECT_EQ(status({"report", "merge", "nowhere", "--out", "x"}), 3);
}

}  // namespace
}  // namespace voxcone
