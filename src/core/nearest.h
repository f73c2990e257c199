// "Did you mean …?"
#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace voxcone {

/// Levenshtein distance: how many letters must be put in, left out or changed to make one word of the other.
inline std::size_t editDistance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
        }
    }
    return row.back();
}

/// The word of `words` (not empty) that is nearest to `word`; the first of several. An abbreviation counts as one
/// letter away from the whole.
inline std::string nearestWord(const std::vector<std::string>& words, const std::string& word) {
    const auto distance = [&](const std::string& candidate) {
        const bool abbreviation = word.size() > 1 && candidate.starts_with(word);
        return abbreviation ? std::size_t{1} : editDistance(candidate, word);
    };
    return *std::min_element(words.begin(), words.end(),
                             [&](const std::string& a, const std::string& b) { return distance(a) < distance(b); });
}

}  // namespace voxcone
