// The cheapest of many combinations of settings that meets a bound on the error, found with few measurements. Pure.
//
// Knobs have values in order, from the cheapest and least accurate one. Logarithms of time and error are modelled as
// sums of what each step of each knob changes, and of what two knobs change together; steps have a Gaussian prior, so
// that the model is a Gaussian process whose kernel is that of random walks along the knobs. The next combination to
// measure is the one with the largest expected gain in time, times the probability that it meets the bound (J. Gardner
// et al. 2014, "Bayesian Optimization with Inequality Constraints"). Where measuring it is expected to take more than
// twice as long as usual, its gain counts for that much less (J. Snoek et al. 2012, "Practical
// Bayesian Optimization of Machine Learning Algorithms", 3.2, whose gain per second lets what the clock happens to say
// decide between all): voxels and light may take minutes to build where a frame takes milliseconds. Pictures to search
// with may be smaller than those that are meant: the best found are measured again as they are meant, and tell how far
// small pictures err.
#pragma once

#include <functional>
#include <optional>
#include <vector>

namespace voxcone {

/// Index of the value of each knob.
using Choice = std::vector<int>;

/// What a choice costs; time and error > 0 and finite.
struct Cost {
    double milliseconds = 0, error = 0;
    /// Seconds that measuring it took: to build voxels and light, and for the rest. 0 when all take alike.
    double building = 0, rendering = 0;
};

struct SearchSpace {
    std::vector<int> sizes;  ///< values of each knob, at least 1
    /// Measured first, in this order; at least one.
    std::vector<Choice> seeds;
    /// Maps choices that make the same picture to one of them; identity when empty.
    std::function<Choice(Choice)> canonical;
    /// By knob: by what one step raises the logarithm of the seconds that a measurement takes, as far as is known
    /// before one; 0.2 each when empty.
    std::vector<double> efforts;
    bool smallPictures = false;  ///< errors of Stage::search are those of smaller pictures

    Choice canonicalOf(Choice choice) const { return canonical ? canonical(std::move(choice)) : choice; }
};

enum class Stage {
    search,  ///< one choice; pictures may be small, but times are those of the pictures meant
    confirm  ///< a few choices, as they are meant, their repeats in turns
};

/// One answer a choice, in order; none for a choice that cannot be rendered.
using MeasureChoices = std::function<std::vector<std::optional<Cost>>(const std::vector<Choice>&, Stage)>;

struct SearchResult {
    struct Probe {
        Choice choice;
        std::optional<Cost> cost;       ///< of the search; none when it failed
        std::optional<Cost> confirmed;  ///< as meant
    };
    std::vector<Probe> probes;  ///< in the order measured
    std::optional<int> best;    ///< index of the cheapest confirmed probe that meets the bound
    int measurements = 0;       ///< of choices, in both stages
    double pictureFactor = 1;   ///< error of the pictures meant over that of those searched with
};

/// Searches with at most `budget` measurements (at least one for each seed and one more), of which
/// some confirm. Without a choice that meets `maxError` the one that seems to err least is confirmed and `best` stays
/// empty. The same answers give the same search.
SearchResult searchCheapest(const SearchSpace& space, double maxError, int budget, const MeasureChoices& measure);

}  // namespace voxcone
