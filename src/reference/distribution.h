// Choice among weighted items by inverting their cumulative distribution.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace voxcone {

/// Item k is chosen with probability weight_k / Σ weight.
class Distribution {
  public:
    Distribution() = default;

    /// Weights are finite and not negative. When all are zero the distribution is empty: nothing can be chosen.
    explicit Distribution(const std::vector<double>& weights) {
        double sum = 0;
        for (const double weight : weights) sum += weight;
        if (!(sum > 0)) return;
        cumulative_.reserve(weights.size() + 1);
        double running = 0;
        cumulative_.push_back(0);
        for (const double weight : weights) {
            running += weight;
            cumulative_.push_back(static_cast<float>(running / sum));
        }
        // Rounding must not let u = 1 − ulp fall behind the last item that has a weight.
        const float last = cumulative_.back();
        for (std::size_t k = cumulative_.size(); k-- > 0 && cumulative_[k] == last;) cumulative_[k] = 1;
    }

    bool empty() const { return cumulative_.empty(); }

    /// The item at `u` in [0, 1); `u` becomes the remainder, again uniform in [0, 1).
    std::size_t sample(float& u) const {
        const auto above = std::upper_bound(cumulative_.begin(), cumulative_.end(), u);
        const auto item = static_cast<std::size_t>(above - cumulative_.begin()) - 1;
        u = std::min((u - cumulative_[item]) / probability(item), 0x1.fffffep-1f);
        return item;
    }

    float probability(std::size_t item) const { return cumulative_[item + 1] - cumulative_[item]; }

  private:
    std::vector<float> cumulative_;
};

}  // namespace voxcone
