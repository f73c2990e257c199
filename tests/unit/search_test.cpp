// The search for the cheapest choice against exhaustive answers, on made-up figures with counted measurements.
#include "report/search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <random>

namespace voxcone {
namespace {

using Table = std::map<Choice, Cost>;

/// Figures as settings give them: times of two passes, each a product over the knobs that it depends on, and a rest;
/// errors that add up, over a floor. Now and then a step is cheaper, or errs more, than the one before.
/// `interacting`: pairs of knobs change the error together as well.
Table world(unsigned seed, const std::vector<int>& sizes, bool interacting) {
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
    };
    const std::size_t knobs = sizes.size();
    std::vector<std::vector<double>> time(knobs), error(knobs);
    std::vector<std::size_t> pass(knobs);
    for (std::size_t k = 0; k < knobs; ++k) {
        pass[k] = uniform(0, 1) < 0.6 ? 0 : 1;
        const double slower = uniform(0.02, 0.7), better = uniform(-0.1, 1.5);
        double t = 1, e = std::exp(uniform(-3, 0));
        for (int i = 0; i < sizes[k]; ++i) {
            time[k].push_back(t), error[k].push_back(e);
            t *= std::exp(slower * uniform(0.5, 1.5)), e *= std::exp(-better * uniform(0.3, 1.7));
        }
    }
    std::vector<double> pairs(knobs * knobs, 0);
    if (interacting)
        for (double& pair : pairs) pair = uniform(-0.3, 0.3);
    Table table;
    Choice choice(knobs, 0);
    for (std::size_t k = 0; k < knobs;) {
        double passes[2] = {3, 2}, sum = 0.02, together = 0;
        for (std::size_t i = 0; i < knobs; ++i) {
            const auto value = static_cast<std::size_t>(choice[i]);
            passes[pass[i]] *= time[i][value];
            sum += 0.3 * error[i][value];
            for (std::size_t j = 0; j < i; ++j)
                together += pairs[i * knobs + j] * choice[i] * choice[j] / ((sizes[i] - 1) * (sizes[j] - 1));
        }
        table[choice] = {passes[0] + passes[1] + 1, sum * std::exp(together)};
        for (k = 0; k < knobs && ++choice[k] == sizes[k]; ++k) choice[k] = 0;
    }
    return table;
}

SearchSpace spaceOf(const std::vector<int>& sizes) {
    SearchSpace space;
    space.sizes = sizes;
    Choice lowest(sizes.size(), 0), middle, highest;
    for (const int size : sizes) middle.push_back(size / 2), highest.push_back(size - 1);
    space.seeds = {middle, lowest, highest};
    return space;
}

/// Answers from a table, and counts.
struct Answers {
    const Table& table;
    double noise = 0;                                  ///< standard deviation of the logarithm of times
    double pictureFactor = 1;                          ///< errors of the search are less by it
    std::function<double(const Choice&)> effort = {};  ///< seconds to build; untold when empty
    int calls = 0;
    std::mt19937 random{5};

    std::vector<std::optional<Cost>> operator()(const std::vector<Choice>& choices, Stage stage) {
        std::vector<std::optional<Cost>> out;
        for (const Choice& choice : choices) {
            ++calls;
            Cost cost = table.at(choice);
            if (noise > 0) cost.milliseconds *= std::exp(std::normal_distribution(0.0, noise)(random));
            if (stage == Stage::search) cost.error /= pictureFactor;
            if (effort) cost.building = effort(choice), cost.rendering = 1;
            out.emplace_back(cost);
        }
        return out;
    }
};

double boundAt(const Table& table, double share) {
    std::vector<double> errors;
    for (const auto& [choice, cost] : table) errors.push_back(cost.error);
    std::sort(errors.begin(), errors.end());
    return errors[static_cast<std::size_t>(share * static_cast<double>(errors.size() - 1))];
}

double cheapestOf(const Table& table, double bound) {
    double cheapest = 1e300;
    for (const auto& [choice, cost] : table)
        if (cost.error <= bound) cheapest = std::min(cheapest, cost.milliseconds);
    return cheapest;
}

struct Score {
    int within = 0, total = 0;  ///< a tenth of the exhaustive optimum, by the true times
};

/// Over worlds and bounds, with a quarter of the exhaustive measurements. What is found always meets the bound.
Score score(const std::vector<int>& sizes, bool interacting, double noise, double pictureFactor) {
    Score score;
    for (unsigned seed = 0; seed < 30; ++seed) {
        const Table table = world(seed, sizes, interacting);
        for (const double share : {0.15, 0.4, 0.7}) {
            const double bound = boundAt(table, share);
            SearchSpace space = spaceOf(sizes);
            space.smallPictures = pictureFactor != 1;
            Answers answers{table, noise, pictureFactor};
            const int budget = static_cast<int>(table.size()) / 4;
            const SearchResult result = searchCheapest(space, bound, budget, std::ref(answers));
            EXPECT_EQ(answers.calls, result.measurements);
            EXPECT_LE(answers.calls, budget);
            ++score.total;
            if (!result.best) continue;
            const Cost found = table.at(result.probes[static_cast<std::size_t>(*result.best)].choice);
            EXPECT_LE(found.error, bound);
            score.within += found.milliseconds <= 1.1 * cheapestOf(table, bound);
        }
    }
    return score;
}

class Searches : public testing::TestWithParam<std::vector<int>> {};
INSTANTIATE_TEST_SUITE_P(Grids, Searches,
                         testing::Values(std::vector{4, 4, 4}, std::vector{4, 4, 3}, std::vector{3, 4, 2, 2},
                                         std::vector{2, 2, 2, 2, 2, 2}, std::vector{4, 4, 4, 4}));

TEST_P(Searches, MonotoneFiguresWithAQuarterOfTheMeasurements) {
    const Score s = score(GetParam(), false, 0, 1);
    EXPECT_GE(s.within, 0.95 * s.total);
}

TEST_P(Searches, InteractingFigures) {
    const Score s = score(GetParam(), true, 0, 1);
    EXPECT_GE(s.within, 0.85 * s.total);
}

TEST_P(Searches, NoisyTimes) {
    const Score s = score(GetParam(), false, 0.05, 1);
    EXPECT_GE(s.within, 0.9 * s.total);
}

TEST_P(Searches, SmallPicturesThatErrLess) {
    const Score s = score(GetParam(), false, 0, 1.3);
    EXPECT_GE(s.within, 0.85 * s.total);
}

/// The last knob builds light: it changes the error but hardly the time, and takes four times as long to build at each
/// of its values.
TEST(Search, ShortMeasurementsComeFirst) {
    const std::vector<int> sizes = {4, 4, 4};
    const auto effort = [](const Choice& choice) { return std::pow(4.0, choice[2]) * (1 + 0.1 * choice[0]); };
    double told = 0, untold = 0;  // seconds until something within a tenth of the cheapest is measured
    Score found;
    for (unsigned seed = 0; seed < 40; ++seed) {
        Table table = world(seed, sizes, true);
        for (auto& [choice, cost] : table)
            cost.milliseconds = table.at({choice[0], choice[1], 0}).milliseconds * (1 + 0.01 * choice[2]);
        for (const double share : {0.3, 0.6}) {
            const double bound = boundAt(table, share), good = 1.1 * cheapestOf(table, bound);
            SearchSpace space;
            space.sizes = sizes, space.seeds = {{2, 2, 1}, {0, 0, 0}};
            for (const bool tell : {false, true}) {
                Answers answers{table};
                if (tell) answers.effort = effort;
                const SearchResult result = searchCheapest(space, bound, 20, std::ref(answers));
                for (const SearchResult::Probe& probe : result.probes) {
                    (tell ? told : untold) += effort(probe.choice);
                    if (probe.cost->error <= bound && probe.cost->milliseconds <= good) break;
                }
                if (!tell) continue;
                ++found.total;
                found.within +=
                    result.best &&
                    table.at(result.probes[static_cast<std::size_t>(*result.best)].choice).milliseconds <= good;
            }
        }
    }
    EXPECT_LE(told, 0.7 * untold);
    EXPECT_GE(found.within, 0.95 * found.total);
}

TEST(Search, TheSameAnswersGiveTheSameSearch) {
    const Table table = world(3, {4, 4, 4}, true);
    Answers a{table}, b{table};
    const SearchResult first = searchCheapest(spaceOf({4, 4, 4}), 0.3, 16, std::ref(a));
    const SearchResult second = searchCheapest(spaceOf({4, 4, 4}), 0.3, 16, std::ref(b));
    ASSERT_EQ(first.probes.size(), second.probes.size());
    for (std::size_t i = 0; i < first.probes.size(); ++i) EXPECT_EQ(first.probes[i].choice, second.probes[i].choice);
}

TEST(Search, SaysWhenNothingMeetsTheBound) {
    const Table table = world(1, {4, 4, 4}, false);
    const double least = boundAt(table, 0);
    Answers answers{table};
    const SearchResult result = searchCheapest(spaceOf({4, 4, 4}), 0.5 * least, 16, std::ref(answers));
    EXPECT_FALSE(result.best);
    double found = 1e300;
    int confirmed = 0;
    for (const SearchResult::Probe& probe : result.probes) {
        found = std::min(found, probe.cost->error);
        confirmed += probe.confirmed.has_value();
    }
    EXPECT_GE(confirmed, 1);
    EXPECT_LE(found, 1.1 * least);
}

TEST(Search, GoesOnWithoutChoicesThatCannotBeRendered) {
    const Table table = world(2, {4, 4, 4}, false);
    const double bound = boundAt(table, 0.4);
    Answers answers{table};
    // What has the last value of the first knob does not fit on the device.
    Table rest;
    for (const auto& [choice, cost] : table)
        if (choice[0] < 3) rest[choice] = cost;
    const MeasureChoices measure = [&](const std::vector<Choice>& choices, Stage stage) {
        auto costs = answers(choices, stage);
        for (std::size_t i = 0; i < choices.size(); ++i)
            if (choices[i][0] == 3) costs[i].reset();
        return costs;
    };
    const SearchResult result = searchCheapest(spaceOf({4, 4, 4}), bound, 16, measure);
    ASSERT_TRUE(result.best);
    const Cost found = rest.at(result.probes[static_cast<std::size_t>(*result.best)].choice);
    EXPECT_LE(found.error, bound);
    EXPECT_LE(found.milliseconds, 1.1 * cheapestOf(rest, bound));
}

TEST(Search, NothingRendersAtAll) {
    const MeasureChoices measure = [](const std::vector<Choice>& choices, Stage) {
        return std::vector<std::optional<Cost>>(choices.size());
    };
    const SearchResult result = searchCheapest(spaceOf({4, 4}), 1, 16, measure);
    EXPECT_FALSE(result.best);
    EXPECT_EQ(result.measurements, 3);
}

TEST(Search, ChoicesThatMakeTheSamePictureAreMeasuredOnce) {
    SearchSpace space = spaceOf({3, 4});
    space.canonical = [](Choice choice) {
        if (choice[0] == 0) choice[1] = 0;
        return choice;
    };
    std::map<Choice, int> seen;
    const MeasureChoices measure = [&](const std::vector<Choice>& choices, Stage stage) {
        std::vector<std::optional<Cost>> costs;
        for (const Choice& choice : choices) {
            EXPECT_EQ(space.canonical(choice), choice);
            if (stage == Stage::search) ++seen[choice];
            costs.emplace_back(Cost{1.0 + choice[0] + choice[1], 1.0 / (1 + choice[0] + choice[1])});
        }
        return costs;
    };
    EXPECT_TRUE(searchCheapest(space, 0.3, 30, measure).best);
    EXPECT_LE(seen.size(), 9u);
    for (const auto& [choice, count] : seen) EXPECT_EQ(count, 1);
}

TEST(Search, MillionsOfChoices) {
    // Twelve knobs of four values; times are products and errors as well, so that the optimum is that of a knapsack.
    constexpr int kKnobs = 12, kValues = 4, kUnits = 140;  // logarithm of the error in hundredths
    std::mt19937 random(11);
    std::vector<std::array<double, kValues>> time(kKnobs);
    std::vector<std::array<int, kValues>> error(kKnobs);
    for (int k = 0; k < kKnobs; ++k) {
        double t = 0;
        int e = 0;
        const double slower = 0.02 + 0.3 * static_cast<double>(random() % 1000) / 1000;
        const int better = static_cast<int>(random() % 20);
        for (std::size_t i = 0; i < kValues; ++i) {
            time[static_cast<std::size_t>(k)][i] = t, error[static_cast<std::size_t>(k)][i] = e;
            t += slower, e += better;
        }
    }
    // least[u]: least logarithm of time that gains u hundredths.
    std::vector<double> least(kUnits + 1, 1e300);
    least[0] = 0;
    for (int k = 0; k < kKnobs; ++k) {
        std::vector<double> next(kUnits + 1, 1e300);
        for (int u = 0; u <= kUnits; ++u)
            for (std::size_t i = 0; i < kValues; ++i) {
                const int gained = std::min(u + error[static_cast<std::size_t>(k)][i], kUnits);
                double& cell = next[static_cast<std::size_t>(gained)];
                cell = std::min(cell, least[static_cast<std::size_t>(u)] + time[static_cast<std::size_t>(k)][i]);
            }
        least = next;
    }
    int calls = 0;
    const MeasureChoices measure = [&](const std::vector<Choice>& choices, Stage) {
        std::vector<std::optional<Cost>> costs;
        for (const Choice& choice : choices) {
            double t = 0, e = 0;
            for (std::size_t k = 0; k < choice.size(); ++k) {
                t += time[k][static_cast<std::size_t>(choice[k])];
                e += error[k][static_cast<std::size_t>(choice[k])];
            }
            ++calls;
            costs.emplace_back(Cost{std::exp(t), std::exp(-e / 100)});
        }
        return costs;
    };
    const SearchResult result =
        searchCheapest(spaceOf(std::vector<int>(kKnobs, kValues)), std::exp(-kUnits / 100.0) * 1.0001, 60, measure);
    ASSERT_TRUE(result.best);
    EXPECT_LE(calls, 60);
    const double found = std::log(result.probes[static_cast<std::size_t>(*result.best)].confirmed->milliseconds);
    EXPECT_LE(found, least[kUnits] + 0.1);
}

}  // namespace
}  // namespace voxcone
