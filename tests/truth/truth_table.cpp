// The table of exact answers (docs/accuracy.md): every row through the renderer's own voxels, light and cones, at
// several phases of the voxel grid and four orientations.
//
//   truth_table                 rows by the presets, which must keep their bars; takes the options of GoogleTest
//   truth_table --docs FILE     all of them, and once more for each storage and cone set, into FILE as Markdown
//
// A row that misses its bar is printed as MISSED and holds a second bound, what was measured and a little, so that it
// gets no worse (Bar::missed).

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "cases.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "support/closed_forms.h"

namespace voxcone::test {
namespace {

const std::array<std::string, 2> kPresets{"balanced", "accurate"};

Settings preset(const std::string& name) {
    Settings settings;
    applyPreset(settings, name);
    return settings;
}

double figureOf(Figure figure, const Errors& errors) {
    switch (figure) {
        case Figure::mean:
            return std::abs(errors.mean());
        case Figure::relative_mean:
            return std::abs(errors.mean() / errors.truth());
        case Figure::rms:
            return errors.rms();
        case Figure::worst:
            return errors.worst;
    }
    return 0;
}

const char* nameOf(Figure figure) {
    const std::array names{"mean", "relative mean", "RMSE", "worst"};
    return names[static_cast<std::size_t>(figure)];
}

/// Results of a case with one tree of settings: by orientation, then by answer.
using Results = std::vector<std::vector<Errors>>;

Results measureAll(const Case& case_, const Settings& settings) {
    Results results;
    for (const Orientation& orientation : orientations()) results.push_back(measure(case_, orientation, settings));
    return results;
}

Errors overOrientations(const Results& results, std::size_t answer) {
    Errors all;
    for (const auto& errors : results) all.add(errors[answer]);
    return all;
}

/// The figure of the orientation where it is largest.
struct Largest {
    double figure = 0;
    std::string orientation;
};
Largest largest(const Results& results, std::size_t answer, Figure figure) {
    Largest out;
    for (std::size_t i = 0; i < results.size(); ++i) {
        const double value = figureOf(figure, results[i][answer]);
        if (i == 0 || value > out.figure) out = {value, orientations()[i].name};
    }
    return out;
}

class TruthTable : public ::testing::TestWithParam<std::tuple<std::size_t, std::string>> {};

TEST_P(TruthTable, KeepsItsBars) {
    const auto& [index, name] = GetParam();
    const Case& case_ = cases()[index];
    glContext().makeCurrent();
    const Results results = measureAll(case_, preset(name));
    for (std::size_t k = 0; k < case_.answers.size(); ++k) {
        const Answer& answer = case_.answers[k];
        const Errors all = overOrientations(results, k);
        ASSERT_TRUE(std::isfinite(all.squares)) << answer.title;
        fmt::print("{:2} {:50} value {:7.4f} truth {:7.4f} mean {:+.4f} RMSE {:.4f} worst {:.4f}\n", case_.row,
                   answer.title, all.value(), all.truth(), all.mean(), all.rms(), all.worst);
        for (const Bar& bar : answer.bars) {
            const Largest most = largest(results, k, bar.figure);
            fmt::print("   {} {:.4f} ({}), bar {}{}\n", nameOf(bar.figure), most.figure, most.orientation,
                       bar.bar[name], most.figure > bar.bar[name] ? ": MISSED" : "");
            const double bound = bar.missed[name] > 0 ? bar.missed[name] : bar.bar[name];
            EXPECT_LE(most.figure, bound) << answer.title << ", rotated by " << most.orientation;
        }
    }
    EXPECT_NO_THROW(glContext().checkErrors());
}

INSTANTIATE_TEST_SUITE_P(Rows, TruthTable,
                         ::testing::Combine(::testing::Range(std::size_t{0}, cases().size()),
                                            ::testing::ValuesIn(kPresets)),
                         [](const auto& row) {
                             const Case& case_ = cases()[std::get<0>(row.param)];
                             return case_.row + case_.name + "_" + std::get<1>(row.param);
                         });

// The closed forms that the truths are made of have the values of the literature.
TEST(ClosedForms, HaveTheirPublishedValues) {
    const glm::dvec3 at(0), up(0, 1, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    EXPECT_NEAR(rectangleFactor(at, up, y, x, z), 0.138532, 1e-6);                               // C1
    EXPECT_NEAR(rectangleFactor(at, up, y - x - z, 2.0 * x, 2.0 * z), 0.554126, 1e-6);           // C1
    EXPECT_NEAR(rectangleFactor(at, up, z, x, y), 0.0557342, 1e-7);                              // C2
    EXPECT_NEAR(rectangleFactor(at, up, z - y, x, 2.0 * y), 0.0557342, 1e-7);                    // C3
    EXPECT_NEAR(rectangleFactor(at, up, z, 0.5 * x, 2.0 * y), 0.0581339, 1e-7);                  // C2
    EXPECT_NEAR(rectangleFactor(at, up, y - 0.5 * (x + z), x, z), 0.239456, 1e-6);               // B7
    EXPECT_NEAR(1 - boxFactor(at, up, {1, 0, -1e4}, {2, 1, 1e4}), 0.853553, 1e-6);               // B2
    EXPECT_NEAR(1 - rectangleFactor(at, up, {0.5, 1, -1e4}, 1e4 * x, 2e4 * z), 0.723607, 1e-4);  // B4
    for (const auto& [cosine, factor] :
         {std::pair{0.8, 0.2}, {0.2, 0.0593458}, {0.0, 0.0288344}, {-0.2, 0.0093458}})  // B5, B6
        EXPECT_NEAR(sphereFactor(at, up, {std::sqrt(1 - cosine * cosine), cosine, 0}, 0.5), factor, 1e-6);
    for (const auto& [t, visible] : {std::pair{-0.5, 0.195501}, {0.25, 0.657481}, {0.9, 0.981307}})
        EXPECT_NEAR(discPastEdge(t), visible, 1e-6);  // K1
}

// The documentation.

std::string barsOf(const Answer& answer, const std::map<std::string, Results>& byPreset, std::size_t k) {
    std::vector<std::string> texts;
    for (const Bar& bar : answer.bars) {
        std::string text = bar.bar.balanced == bar.bar.accurate
                               ? fmt::format("{} ≤ {}", nameOf(bar.figure), bar.bar.balanced)
                               : fmt::format("{} ≤ {}, {}", nameOf(bar.figure), bar.bar.balanced, bar.bar.accurate);
        std::vector<std::string> misses;
        for (const std::string& name : kPresets) {
            const Largest most = largest(byPreset.at(name), k, bar.figure);
            if (most.figure > bar.bar[name])
                misses.push_back(fmt::format("{} {:.4f} at {}", name, most.figure, most.orientation));
        }
        if (!misses.empty()) text += fmt::format("; **missed**: {}", fmt::join(misses, ", "));
        texts.push_back(text);
    }
    return fmt::format("{}", fmt::join(texts, "; "));
}

std::string markdown() {
    std::map<std::string, std::vector<Results>> byPreset;
    for (const std::string& name : kPresets)
        for (const Case& case_ : cases()) {
            fmt::print(stderr, "{}: {} {}\n", name, case_.row, case_.name);
            byPreset[name].push_back(measureAll(case_, preset(name)));
        }
    std::string text =
        "By the presets as they stand, over all phases and orientations. Bars hold in each orientation by itself; two "
        "numbers are for `balanced` and `accurate`.\n\n"
        "| row | case | truth | `balanced` | error | RMSE | worst | `accurate` | error | RMSE | worst | bar |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|\n";
    for (std::size_t c = 0; c < cases().size(); ++c)
        for (std::size_t k = 0; k < cases()[c].answers.size(); ++k) {
            const Answer& answer = cases()[c].answers[k];
            std::map<std::string, Results> ofCase;
            text += fmt::format("| {} | {} | {:.4f}", cases()[c].row, answer.title,
                                overOrientations(byPreset.at("balanced")[c], k).truth());
            for (const std::string& name : kPresets) {
                ofCase[name] = byPreset.at(name)[c];
                const Errors all = overOrientations(ofCase[name], k);
                text +=
                    fmt::format(" | {:.4f} | {:+.4f} | {:.4f} | {:.4f}", all.value(), all.mean(), all.rms(), all.worst);
            }
            text += fmt::format(" | {} |\n", barsOf(answer, ofCase, k));
        }

    const std::array<const char*, 3> storages{"six_face", "sh1", "isotropic"};
    const std::array cones{6, 16, 32};
    std::vector<std::vector<std::vector<Errors>>> columns;
    text +=
        "\nRMSE of `balanced` with other `voxel.storage` and `cone.diffuse`, at the orientation `random` alone.\n\n"
        "| row | case |";
    std::string rule = "|---|---|";
    for (const char* storage : storages)
        for (const int count : cones) {
            text += fmt::format(" {} {} |", storage, count);
            rule += "---|";
            Settings settings = preset("balanced");
            applyAssignment(settings, fmt::format("voxel.storage={}", storage));
            settings.cone.diffuse = count;
            auto& column = columns.emplace_back();
            for (const Case& case_ : cases()) {
                fmt::print(stderr, "{} {}: {} {}\n", storage, count, case_.row, case_.name);
                column.push_back(measure(case_, orientations().back(), settings));
            }
        }
    text += "\n" + rule + "\n";
    for (std::size_t c = 0; c < cases().size(); ++c)
        for (std::size_t k = 0; k < cases()[c].answers.size(); ++k) {
            text += fmt::format("| {} | {} |", cases()[c].row, cases()[c].answers[k].title);
            for (const auto& column : columns) text += fmt::format(" {:.4f} |", column[c][k].rms());
            text += "\n";
        }
    return text;
}

/// `file` with `table` between its two marks. Throws InputError when they are not there.
std::string withTable(const std::string& file, const std::string& table) {
    const std::string begin = "<!-- truth_table -->", end = "<!-- /truth_table -->";
    std::string text = readTextFile(file);
    const auto from = text.find(begin), to = text.find(end);
    if (from == std::string::npos || to == std::string::npos || to < from)
        throw InputError(file, "", fmt::format("has no {} and {}", begin, end));
    const std::size_t first = from + begin.size();
    return text.replace(first, to - first, "\n\n" + table + "\n");
}

void renewDocs(const std::string& file) {
    withTable(file, "");  // before the work
    const std::string table = markdown();
    writeTextFile(file, withTable(file, table));
}

}  // namespace
}  // namespace voxcone::test

int main(int argc, char** argv) {
    ::testing::InitGoogleTest(&argc, argv);
    if (argc == 1) return RUN_ALL_TESTS();
    if (argc != 3 || std::string(argv[1]) != "--docs") {
        fmt::print(stderr, "usage: truth_table [--docs FILE] [--gtest_...]\n");
        return 2;
    }
    try {
        voxcone::test::glContext().makeCurrent();
        voxcone::test::renewDocs(argv[2]);
    } catch (const std::exception& error) {
        fmt::print(stderr, "{}\n", error.what());
        return 3;
    }
    return 0;
}
