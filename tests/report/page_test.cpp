#include "report/page.h"
#include <fmt/format.h>
#include <gtest/gtest.h>
#include "core/atomic_file.h"
#include "report/page_sample.h"
namespace voxcone {
TEST(Page, Main) {
    const std::filesystem::path folder = VOXCONE_PAGES;
    const auto report = sampleReport(folder / "main");
    writeTextFile(folder / "main.html", makePage(report, folder / "main"));
    writeTextFile(folder / "many.html", makePage(plainReport(200), folder));
}
}  // namespace voxcone
