// The page in headless Chromium, at a desk's and a phone's width: what it draws, and what a reader can do with it. The
// pages stay in the build folder to be looked at.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "metric/image.h"
#include "report/page.h"
#include "report/page_sample.h"

namespace voxcone {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

namespace {

const fs::path kPages = VOXCONE_PAGES;
constexpr const char* kHostile = "<script>document.title='no'</script></script><!-- \"&' @SCRIPT@";
constexpr const char* kUnicode = "ライト 光 ꟻLIP \U0001F4A1 ñandú";

/// Reports whose pages are looked at, by name.
std::map<std::string, json> makeReports() {
    std::map<std::string, json> reports;
    reports["main"] = sampleReport(kPages / "main");
    reports["many"] = plainReport(200);
    reports["one"] = plainReport(1);
    reports["none"] = plainReport(0);
    reports["bare"] = json::object();

    json& failed = reports["failed"] = plainReport(3);
    for (json& row : failed["rows"]) {
        row = {
            {"view", row["view"]}, {"configuration", row["configuration"]}, {"status", "failed"}, {"reason", kHostile}};
    }

    json& odd = reports["odd"] = plainReport(6);
    odd["suite"]["name"] = kHostile;
    odd["views"][0]["id"] = kUnicode;
    const auto rename = [&](std::size_t index, const std::string& name) {
        odd["configurations"][index]["id"] = name, odd["rows"][index]["configuration"] = name;
    };
    rename(1, kHostile);
    rename(2, std::string(200, 'x'));
    rename(3, kUnicode);
    odd["configurations"][1]["set"] = {{kHostile, kHostile}};
    for (json& row : odd["rows"]) row["view"] = kUnicode;
    odd["rows"][0]["errors"]["beauty"] = {{"relmse", 0}, {"psnr", nullptr}};  // equal to the reference
    odd["rows"][4]["errors"] = json::object();
    odd["rows"][5]["errors"]["beauty"]["relmse"] = nullptr;
    odd["rows"][1]["images"] = {{"beauty", "images/missing.png"}, {"beauty_heatmap", nullptr}};
    return reports;
}

std::string percentDecoded(const std::string& text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%')
            out += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16)), i += 2;
        else
            out += text[i];
    }
    return out;
}

class Page : public testing::Test {
  protected:
    /// Makes all pages and opens them in one run of the browser, each in a frame as wide as a window would be:
    /// Chromium's own window is never narrower than 500 pixels.
    static void SetUpTestSuite() {
        reports_ = makeReports();
        const std::string check = readTextFile(fs::path(VOXCONE_SOURCE_DIR) / "tests/report/page_check.js");
        std::string frames;
        int count = 0;
        for (const auto& [name, report] : reports_) {
            pages_[name] = makePage(report, kPages / name);
            writeTextFile(kPages / (name + ".html"), pages_[name]);
            std::string checked = pages_[name];
            checked.insert(checked.rfind("</body>"), "<script>\n" + check + "</script>\n");
            writeTextFile(kPages / (name + "-checked.html"), checked);
            for (const int width : {1280, 360}) {
                const char* use = name == "main" ? "&use" : "";
                frames += fmt::format(
                    "<iframe src='{0}-checked.html?name={0}-{1}&theme={2}{3}' width={1} height=900></iframe>\n", name,
                    width, width == 360 ? "dark" : "light", use);
                ++count;
            }
        }
        const fs::path around = kPages / "all.html";
        writeTextFile(around, fmt::format(R"(<!doctype html><script>
const found = {{}};
addEventListener("message", (event) => {{
  const message = JSON.parse(event.data);
  found[message.name] = message.found;
  if (Object.keys(found).length === {}) document.documentElement.dataset.found = encodeURIComponent(JSON.stringify(found));
}});
</script>
{})",
                                          count, frames));
        const fs::path out = kPages / "dom.txt";
        const std::string line = fmt::format(
            "timeout 120 chromium --headless=new --no-sandbox --disable-gpu --user-data-dir='{}' "
            "--window-size=1280,900 --virtual-time-budget=20000 --dump-dom 'file://{}' >'{}' 2>'{}' </dev/null",
            (kPages / "profile").string(), around.string(), out.string(), (kPages / "chromium.txt").string());
        ASSERT_EQ(std::system(line.c_str()), 0) << "Chromium (package chromium) is needed: " << line;
        const std::string dom = readTextFile(out), mark = "data-found=\"";
        const std::size_t at = dom.find(mark);
        ASSERT_NE(at, std::string::npos) << "not every page ran to its end: " << dom.substr(0, 2000);
        const std::size_t begin = at + mark.size();
        found_ = json::parse(percentDecoded(dom.substr(begin, dom.find('"', begin) - begin)));
    }

    static std::map<std::string, json> reports_;
    static std::map<std::string, std::string> pages_;
    static json found_;
};
std::map<std::string, json> Page::reports_;
std::map<std::string, std::string> Page::pages_;
json Page::found_;

std::vector<double> numbers(const json& texts) {
    std::vector<double> out;
    for (const json& text : texts) {
        char* end = nullptr;
        const std::string written = text;
        const double value = std::strtod(written.c_str(), &end);
        if (end != written.c_str()) out.push_back(value);
    }
    return out;
}

}  // namespace

TEST_F(Page, AllOpenWithoutErrorRequestOrOverflow) {
    ASSERT_THAT(found_, SizeIs(2 * reports_.size()));
    for (const auto& [name, found] : found_.items()) {
        SCOPED_TRACE(name);
        EXPECT_EQ(found["error"], "");
        EXPECT_EQ(found.value("failure", ""), "");
        EXPECT_THAT(found["requests"], IsEmpty());
        EXPECT_LE(found["overflow"], 0);
        EXPECT_EQ(found["width"], name.ends_with("-360") ? 360 : 1280);
        EXPECT_EQ(found["theme"], name.ends_with("-360") ? "dark" : "light");
        EXPECT_EQ(found["notNumbers"], false);
        EXPECT_THAT(found["oddText"], IsEmpty());
        EXPECT_EQ(found["unlabelled"], 0);
        EXPECT_EQ(found["scripts"], 5);  // none came from a name
    }
    for (const auto& [name, page] : pages_) {
        EXPECT_THAT(page, Not(HasSubstr("http:"))) << name;
        EXPECT_THAT(page, Not(HasSubstr("https:"))) << name;
    }
}

TEST_F(Page, SameReportGivesSameBytes) {
    EXPECT_EQ(makePage(reports_["main"], kPages / "main"), pages_["main"]);
    EXPECT_EQ(makePage(json::parse(reports_["main"].dump()), kPages / "main"), pages_["main"]);
}

TEST_F(Page, PlotsEveryMeasuredRowAndItsFront) {
    EXPECT_EQ(found_["main-1280"]["points"], json({12, 12, 12, 10}));  // all views, then each
    EXPECT_EQ(found_["many-360"]["points"], json({200}));
    EXPECT_EQ(found_["one-360"]["points"], json({1}));
    // By definition: on the front is what no other row beats in one and equals or beats in the other.
    const json& rows = reports_["many"]["rows"];
    std::size_t best = 0;
    for (const json& a : rows) {
        const auto time = [](const json& row) { return row["ms"]["steady"]["median"].get<double>(); };
        const auto error = [](const json& row) { return row["errors"]["beauty"]["relmse"].get<double>(); };
        best += std::none_of(rows.begin(), rows.end(), [&](const json& b) {
            return time(b) <= time(a) && error(b) <= error(a) && (time(b) < time(a) || error(b) < error(a));
        });
    }
    EXPECT_THAT(found_["many-1280"]["front"][0], SizeIs(best));
    EXPECT_EQ(found_["main-1280"]["floors"], 3);  // of the reference's noise, where plots reach down to it
    EXPECT_EQ(found_["many-1280"]["floors"], 0);
}

TEST_F(Page, SortsFiltersPicksAndSaves) {
    const json& found = found_["main-1280"];
    EXPECT_EQ(found["rows"], 36);
    std::vector<double> rising = numbers(found["rising"]), falling = numbers(found["falling"]);
    EXPECT_THAT(rising, SizeIs(34));
    EXPECT_TRUE(std::is_sorted(rising.begin(), rising.end()));
    EXPECT_TRUE(std::is_sorted(falling.rbegin(), falling.rend()));
    EXPECT_THAT(falling, SizeIs(34));
    EXPECT_EQ(found["names"][0], "5 cones");
    EXPECT_EQ(found["names"][35], "thesis");
    EXPECT_EQ(found["filtered"], json({"isotropic", "isotropic", "isotropic"}));
    EXPECT_EQ(found["faded"], json({"isotropic", "isotropic", "isotropic", "isotropic"}));
    EXPECT_EQ(found["nothing"], "0 of 36 rows");
    EXPECT_EQ(found["failed"], json({"resolution 128"}));
    EXPECT_EQ(found["inView"], "atrium/arcade");
    EXPECT_EQ(found["file"], "quick.csv");
    EXPECT_GT(found["csvBytes"], 1000);
    ASSERT_THAT(found["csv"], SizeIs(14));  // titles, twelve rows, and nothing after the last line end
    EXPECT_THAT(found["csv"][0].get<std::string>(), testing::StartsWith("view,configuration,preset,settings,status,"));
    EXPECT_THAT(found["csv"][1].get<std::string>(), HasSubstr("atrium/arcade,5 cones,balanced,cone.diffuse = 5,ok,,"));
    EXPECT_THAT(found["tip"].get<std::string>(), HasSubstr(found["picked"].get<std::string>()));
    EXPECT_EQ(found["pickedInPictures"], found["picked"]);
    EXPECT_EQ(found["ofPass"], json({12, 12, 12, 10}));
    EXPECT_EQ(found["ofAbsentPass"], json({0, 0, 0, 0}));  // a steady frame has no bounces
    EXPECT_EQ(found["enlarged"], 3);
}

TEST_F(Page, HoldsThumbnails) {
    EXPECT_EQ(found_["main-1280"]["comparers"], 3);
    EXPECT_THAT(found_["main-1280"]["images"], SizeIs(34));
    // A wide picture shrinks to 320 pixels, keeping its mean; one that cannot be read is left out.
    const fs::path folder = kPages / "wide";
    Image wide(1000, 10, 3);
    for (std::size_t i = 0; i < wide.data.size(); ++i) wide.data[i] = 0.5f;
    writePng(folder / "wide.png", wide);
    writeTextFile(folder / "text.png", "no picture");
    json report = plainReport(2);
    report["rows"][0]["images"] = {{"beauty", "wide.png"}};
    report["rows"][1]["images"] = {{"beauty", "text.png"}, {"indirect_diffuse", "none.png"}};
    const std::string page = makePage(report, folder);
    EXPECT_THAT(page, HasSubstr("\"wide.png\":\"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAUAAAAAD"));  // 320 × 3
    EXPECT_THAT(page, Not(HasSubstr("\"text.png\":\"data")));
    EXPECT_THAT(page, Not(HasSubstr("\"none.png\":\"data")));
}

TEST_F(Page, SaysWhyThereIsNothingToShow) {
    EXPECT_EQ(found_["none-1280"]["empty"][0], "No rows yet.");
    EXPECT_EQ(found_["none-1280"]["points"], json({0}));
    EXPECT_EQ(found_["failed-1280"]["empty"][0], "All 3 rows failed; the table says why.");
    EXPECT_EQ(found_["failed-1280"]["reasons"], json({kHostile, kHostile, kHostile}));
    EXPECT_THAT(found_["main-1280"]["reasons"].dump(), HasSubstr("GL_MAX_SHADER_STORAGE_BLOCK_SIZE"));
}

TEST_F(Page, ShowsAnyNameAsText) {
    const json& found = found_["odd-1280"];
    EXPECT_EQ(found["elements"][0], kHostile);
    EXPECT_EQ(found["elements"][1], kUnicode);
    EXPECT_EQ(found["points"], json({4}));  // two of six have no error; one of 0 has its lane
    EXPECT_THAT(found["front"][0].dump(), HasSubstr("relMSE of beauty 0"));
    EXPECT_THAT(found["ticks"], testing::Contains("0"));
    EXPECT_EQ(pages_["odd"].find("<script>document"), std::string::npos);
}

}  // namespace voxcone
