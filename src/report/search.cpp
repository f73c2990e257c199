#include "report/search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "core/check.h"

namespace voxcone {

namespace {

struct Prediction {
    double mean = 0, deviation = 0;
};

/// Gaussian process over choices: see search.h. Values are logarithms.
class Model {
  public:
    /// `direction`: +1 when steps of knobs are thought to raise the value, −1 to lower it. `typical`: by how much, by
    /// knob; empty for 20 % each.
    Model(const SearchSpace& space, int direction, const std::vector<double>& typical = {})
        : direction_(direction), typical_(typical.empty() ? std::vector(space.sizes.size(), 0.2) : typical) {
        VOXCONE_CHECK(typical_.size() == space.sizes.size(), "{} of {} knobs", typical_.size(), space.sizes.size());
        parameters_.steps = typical_;
    }

    /// `noise`: the standard deviations that a measurement may have; the likeliest is taken.
    void fit(const std::vector<Choice>& choices, const std::vector<double>& values, const std::vector<double>& noise) {
        choices_ = choices;
        values_ = values;
        parameters_.noise = noise.front();
        // Coordinate ascent of the posterior of the parameters, from those of the fit before.
        double best = factorize();
        const auto improve = [&](double& parameter, const std::vector<double>& candidates) {
            double kept = parameter;
            for (const double candidate : candidates) {
                parameter = candidate;
                if (const double score = factorize(); score > best) best = score, kept = candidate;
            }
            parameter = kept;
        };
        for (int round = 0; round < 2; ++round) {
            for (std::size_t k = 0; k < parameters_.steps.size(); ++k) {
                std::vector<double> candidates;
                for (const double factor : {0.05, 0.15, 0.4, 0.75, 1.5, 3.0, 6.0})
                    candidates.push_back(factor * typical_[k]);
                improve(parameters_.steps[k], candidates);
            }
            improve(parameters_.together, {0.3, 1, 3});
            improve(parameters_.noise, noise);
        }
        factorize();
    }

    Prediction predict(const Choice& choice) const {
        const std::size_t n = choices_.size();
        std::vector<double> k(n);
        double mean = prior(choice);
        for (std::size_t i = 0; i < n; ++i) k[i] = kernel(choice, choices_[i]), mean += k[i] * weights_[i];
        double variance = kernel(choice, choice);
        for (std::size_t i = 0; i < n; ++i) {
            for (std::size_t j = 0; j < i; ++j) k[i] -= lower_[i * n + j] * k[j];
            k[i] /= lower_[i * n + i];
            variance -= k[i] * k[i];
        }
        // What measurements differ by beside the model may be the truth just as well as noise.
        return {mean, std::sqrt(std::max(variance, 1e-8) + parameters_.noise * parameters_.noise)};
    }

  private:
    struct Parameters {
        std::vector<double> steps;  ///< by knob: what one step changes, its mean and standard deviation
        double together = 1;        ///< how much more two knobs change together
        double noise = 0.05;        ///< standard deviation of a measurement
    };

    double prior(const Choice& choice) const {
        double sum = 0;
        for (std::size_t k = 0; k < choice.size(); ++k) sum += parameters_.steps[k] * choice[k];
        return direction_ * sum;
    }

    /// Covariance of two choices: of random walks along the knobs, of their products in pairs, and of the offset.
    double kernel(const Choice& a, const Choice& b) const {
        double sum = 0, squares = 0;
        for (std::size_t k = 0; k < a.size(); ++k) {
            const double walk = parameters_.steps[k] * parameters_.steps[k] * std::min(a[k], b[k]);
            sum += walk, squares += walk * walk;
        }
        constexpr double kOffset = 100;
        return kOffset + sum + 0.5 * parameters_.together * parameters_.together * (sum * sum - squares);
    }

    /// Cholesky factor and weights for the parameters; the logarithm of their posterior but for a constant.
    double factorize() {
        const std::size_t n = choices_.size();
        lower_.assign(n * n, 0);
        weights_.resize(n);
        double score = 0;
        for (std::size_t i = 0; i < n; ++i) {
            double residual = values_[i] - prior(choices_[i]);
            for (std::size_t j = 0; j <= i; ++j) {
                double value = kernel(choices_[i], choices_[j]);
                if (i == j) value += parameters_.noise * parameters_.noise + 1e-9;
                for (std::size_t m = 0; m < j; ++m) value -= lower_[i * n + m] * lower_[j * n + m];
                lower_[i * n + j] = i == j ? std::sqrt(std::max(value, 1e-12)) : value / lower_[j * n + j];
                if (j < i) residual -= lower_[i * n + j] * weights_[j];
            }
            weights_[i] = residual / lower_[i * n + i];
            score -= 0.5 * weights_[i] * weights_[i] + std::log(lower_[i * n + i]);
        }
        for (std::size_t i = n; i-- > 0;) {
            for (std::size_t j = i + 1; j < n; ++j) weights_[i] -= lower_[j * n + i] * weights_[j];
            weights_[i] /= lower_[i * n + i];
        }
        // Steps change what is typical, give or take a factor of three.
        for (std::size_t k = 0; k < typical_.size(); ++k)
            score -= 0.5 * std::pow(std::log(parameters_.steps[k] / typical_[k]) / std::log(3.0), 2);
        return score;
    }

    double direction_;
    std::vector<double> typical_;
    Parameters parameters_;
    std::vector<Choice> choices_;
    std::vector<double> values_, lower_, weights_;
};

double normalDensity(double x) {
    return std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi);
}
double normalBelow(double x) {
    return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}
/// Its logarithm, where it is too small for a number as well.
double logNormalBelow(double x) {
    return x > -20 ? std::log(normalBelow(x)) : -0.5 * x * x - std::log(-x * std::sqrt(2 * std::numbers::pi));
}

/// All choices when there are not too many, else none.
std::vector<Choice> allChoices(const SearchSpace& space) {
    constexpr double kMost = 20000;
    double count = 1;
    for (const int size : space.sizes) count *= size;
    if (count > kMost) return {};
    std::set<Choice> all;
    Choice choice(space.sizes.size(), 0);
    for (;;) {
        all.insert(space.canonicalOf(choice));
        std::size_t k = 0;
        while (k < choice.size() && ++choice[k] == space.sizes[k]) choice[k++] = 0;
        if (k == choice.size()) break;
    }
    return {all.begin(), all.end()};
}

class Search {
  public:
    Search(const SearchSpace& space, double maxError, int budget, const MeasureChoices& measure)
        : space_(space), maxError_(maxError), budget_(budget), measure_(measure), all_(allChoices(space)) {}

    SearchResult run() {
        for (const Choice& seed : space_.seeds) {
            VOXCONE_CHECK(seed.size() == space_.sizes.size(), "{} of {} knobs", seed.size(), space_.sizes.size());
            probe(space_.canonicalOf(seed));
        }
        if (space_.smallPictures) confirm(1);
        // What confirming leaves of the budget goes into searching on. Where pictures are those meant already, it can but
        // time them again.
        const int kept = space_.smallPictures ? kConfirmed : 1;
        bool more = true;
        while (more && result_.measurements < budget_) {
            while (result_.measurements < budget_ - kept) {
                const std::optional<Choice> next = choose();
                if (!next) break;
                probe(*next);
            }
            more = confirm(std::min(kConfirmed, budget_ - result_.measurements));
        }
        return std::move(result_);
    }

  private:
    static constexpr int kConfirmed = 2;  ///< choices that are confirmed together, at most

    double bound() const { return maxError_ / result_.pictureFactor; }

    bool known(const Choice& choice) const {
        return std::any_of(result_.probes.begin(), result_.probes.end(),
                           [&](const SearchResult::Probe& p) { return p.choice == choice; });
    }

    void probe(const Choice& choice) {
        if (known(choice)) return;
        result_.probes.push_back({choice, measure_({choice}, Stage::search).at(0), std::nullopt});
        ++result_.measurements;
        if (const auto& cost = result_.probes.back().cost)
            VOXCONE_CHECK(cost->milliseconds > 0 && cost->error > 0 && std::isfinite(cost->milliseconds + cost->error),
                          "{} ms, error {}", cost->milliseconds, cost->error);
    }

    void fit() {
        std::vector<Choice> choices;
        std::vector<double> times, errors, building, rendering;
        double seconds = 0;  // sum of logarithms
        for (const SearchResult::Probe& p : result_.probes) {
            if (!p.cost) continue;
            choices.push_back(p.choice);
            times.push_back(std::log(p.cost->milliseconds));
            errors.push_back(std::log(p.cost->error));
            if (p.cost->building <= 0 || p.cost->rendering <= 0) continue;
            building.push_back(std::log(p.cost->building));
            rendering.push_back(std::log(p.cost->rendering));
            seconds += std::log(p.cost->building + p.cost->rendering);
        }
        time_.fit(choices, times, {0.01, 0.03, 0.1, 0.25});
        error_.fit(choices, errors, {0.03, 0.08});
        usualSeconds_.reset();
        if (building.size() < choices.size()) return;
        building_.fit(choices, building, {0.03, 0.1, 0.3});
        rendering_.fit(choices, rendering, {0.03, 0.1, 0.3});
        usualSeconds_ = std::exp(seconds / static_cast<double>(choices.size()));
    }

    /// How likely a choice can be rendered: each of its values is blamed for its share of failures.
    double chance(const Choice& choice) const {
        double chance = 1;
        for (std::size_t k = 0; k < choice.size(); ++k) {
            int measured = 0, failed = 0;
            for (const SearchResult::Probe& p : result_.probes)
                if (p.choice[k] == choice[k]) ++measured, failed += !p.cost;
            chance *= 1 - failed / (measured + 1.0);
        }
        return chance;
    }

    /// By how much less, as a logarithm, a choice counts for the time that measuring it takes: in proportion where that
    /// is more than twice the usual. Below that the gain alone decides, not what the clock happens to say.
    double penalty(const Choice& choice) const {
        if (!usualSeconds_) return 0;
        const double seconds = std::exp(building_.predict(choice).mean) + std::exp(rendering_.predict(choice).mean);
        return std::max(std::log(seconds / (2 * *usualSeconds_)), 0.0);
    }

    /// Logarithm of the gain that is expected of measuring a choice: of the logarithm of time, or before the bound is
    /// met once, of the probability that it will be.
    double gain(const Choice& choice, const std::optional<double>& bestTime) const {
        const Prediction error = error_.predict(choice);
        const double margin = (std::log(bound()) - error.mean) / error.deviation;
        const double meets = std::log(chance(choice)) + logNormalBelow(margin);
        if (!bestTime) return meets;
        const Prediction time = time_.predict(choice);
        const double z = (*bestTime - time.mean) / time.deviation;
        return meets + std::log(time.deviation * std::max(z * normalBelow(z) + normalDensity(z), 1e-300));
    }

    /// What to measure next; none when nothing is worth it.
    std::optional<Choice> choose() {
        if (std::none_of(result_.probes.begin(), result_.probes.end(),
                         [](const auto& p) { return p.cost.has_value(); }))
            return std::nullopt;
        fit();
        std::optional<double> bestTime;
        for (const SearchResult::Probe& p : result_.probes)
            if (p.cost && p.cost->error <= bound())
                bestTime = std::min(bestTime.value_or(1e300), std::log(p.cost->milliseconds));
        // A fifth of a per cent is less than times can tell. While nothing meets the bound the model is not believed
        // that nothing will: errors of real scenes go up and down along a ladder where it expects one way.
        const double leastGain = bestTime ? std::log(0.002) : -1e300;
        std::optional<Choice> best;
        bool worthwhile = false;
        double bestScore = -1e300;
        const auto consider = [&](const Choice& choice) {
            const double value = gain(choice, bestTime);
            // What is not worth it comes after all that is, but a climb may lead through it.
            const double score = value - penalty(choice) - (value < leastGain ? 1e6 : 0);
            if (score <= bestScore || known(choice)) return false;
            bestScore = score, best = choice, worthwhile = value >= leastGain;
            return true;
        };
        if (!all_.empty()) {
            for (const Choice& choice : all_) consider(choice);
        } else {
            climb(consider);
        }
        return worthwhile ? best : std::nullopt;
    }

    /// Offers choices at random and around all that is measured, then goes up from the best of them one knob at a time.
    void climb(const std::function<bool(const Choice&)>& consider) {
        Choice top;
        const auto offer = [&](Choice choice) {
            choice = space_.canonicalOf(std::move(choice));
            if (consider(choice)) top = choice;
        };
        const auto neighbours = [&](const Choice& choice) {
            for (std::size_t k = 0; k < choice.size(); ++k) {
                for (int value = 0; value < space_.sizes[k]; ++value) {
                    Choice other = choice;
                    other[k] = value;
                    if (value != choice[k]) offer(other);
                }
            }
        };
        for (int i = 0; i < 2000; ++i) {
            Choice choice;
            for (const int size : space_.sizes) choice.push_back(std::uniform_int_distribution(0, size - 1)(random_));
            offer(choice);
        }
        for (const SearchResult::Probe& p : result_.probes) neighbours(p.choice);
        for (Choice from; from != top;) {
            from = top;
            neighbours(from);
        }
    }

    /// Confirms up to `most` of the cheapest choices that seem to meet the bound, or the one that errs least. False
    /// when all of them are confirmed.
    bool confirm(int most) {
        std::vector<std::size_t> order, meet;
        for (std::size_t i = 0; i < result_.probes.size(); ++i)
            if (result_.probes[i].cost) order.push_back(i);
        if (order.empty()) return false;
        const auto cost = [&](std::size_t i) { return *result_.probes[i].cost; };
        std::sort(order.begin(), order.end(),
                  [&](std::size_t a, std::size_t b) { return cost(a).milliseconds < cost(b).milliseconds; });
        for (const std::size_t i : order)
            if (cost(i).error <= bound()) meet.push_back(i);
        if (meet.empty())
            meet = {*std::min_element(order.begin(), order.end(),
                                      [&](std::size_t a, std::size_t b) { return cost(a).error < cost(b).error; })};
        // What takes 15 % longer than the cheapest is hardly the cheapest, whatever the clock says.
        std::vector<std::size_t> chosen;
        for (const std::size_t i : meet)
            if (static_cast<int>(chosen.size()) < most && !result_.probes[i].confirmed &&
                cost(i).milliseconds <= 1.15 * cost(meet.front()).milliseconds)
                chosen.push_back(i);
        if (chosen.empty()) return false;

        std::vector<Choice> choices;
        for (const std::size_t i : chosen) choices.push_back(result_.probes[i].choice);
        const auto measured = measure_(choices, Stage::confirm);
        result_.measurements += static_cast<int>(choices.size());
        for (std::size_t i = 0; i < chosen.size(); ++i) result_.probes[chosen[i]].confirmed = measured.at(i);
        judge();
        return true;
    }

    /// The best of what is confirmed, and how far small pictures err: by a factor that is about the same for all.
    void judge() {
        double logarithms = 0;
        int count = 0;
        result_.best.reset();
        for (std::size_t i = 0; i < result_.probes.size(); ++i) {
            const auto& p = result_.probes[i];
            if (!p.confirmed) continue;
            logarithms += std::log(p.confirmed->error / p.cost->error), ++count;
            if (p.confirmed->error > maxError_) continue;
            if (!result_.best || p.confirmed->milliseconds <
                                     result_.probes[static_cast<std::size_t>(*result_.best)].confirmed->milliseconds)
                result_.best = static_cast<int>(i);
        }
        if (count > 0 && space_.smallPictures) result_.pictureFactor = std::exp(logarithms / count);
    }

    const SearchSpace& space_;
    const double maxError_;
    const int budget_;
    const MeasureChoices& measure_;
    std::vector<Choice> all_;  ///< canonical; empty when there are too many
    Model time_{space_, +1}, error_{space_, -1}, building_{space_, +1, space_.efforts}, rendering_{space_, +1};
    std::optional<double> usualSeconds_;  ///< geometric mean of what measurements took; none when not told
    std::mt19937 random_{1};
    SearchResult result_;
};

}  // namespace

SearchResult searchCheapest(const SearchSpace& space, double maxError, int budget, const MeasureChoices& measure) {
    return Search(space, maxError, budget, measure).run();
}

}  // namespace voxcone
