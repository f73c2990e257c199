// The rows of docs/accuracy.md as scenes that go through the renderer's own passes.
#pragma once

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/settings.h"
#include "support/voxel_lab.h"

namespace voxcone::test {

/// Errors of one answer over points, placements and orientations.
struct Errors {
    double values = 0, truths = 0, squares = 0, worst = 0;
    int count = 0;

    void add(double value, double truth);
    void add(const Errors& other);
    double value() const { return values / count; }
    double truth() const { return truths / count; }
    double mean() const { return (values - truths) / count; }
    double rms() const;
};

/// What a bar is laid on. It has to hold in every orientation by itself, over all points and phases.
enum class Figure { mean, relative_mean, rms, worst };

struct Bar {
    struct PerPreset {
        double balanced = 0, accurate = 0;
        double operator[](const std::string& preset) const { return preset == "accurate" ? accurate : balanced; }
    };
    Figure figure;
    PerPreset bar;
    /// Where the bar is missed: what the figure may not exceed all the same, a little more than was measured. 0: met.
    PerPreset missed = {0, 0};
};

struct Answer {
    std::string title;
    std::vector<Bar> bars;
};

/// One placement of a case: what it needs, and where its results go.
struct Trial {
    Settings settings;     ///< of the configuration, on the case's grid, without bounces
    double voxel = 0;      ///< edge of a voxel, m
    glm::dmat4 placement;  ///< orientation, and a part of a voxel aside: for the whole scene
    std::mt19937 random;
    std::vector<Errors>& errors;  ///< one an answer

    double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
    void add(std::size_t answer, double value, double truth) { errors[answer].add(value, truth); }
};

struct Case {
    std::string row, name;  ///< as in docs/accuracy.md; letters and digits
    std::vector<Answer> answers;
    int resolution = 64;
    double voxel = 0.125;  ///< m
    int phases = 2;
    std::function<void(Trial&)> measure;
};
const std::vector<Case>& cases();

struct Orientation {
    const char* name;
    glm::dmat4 matrix;
};
const std::vector<Orientation>& orientations();

/// Runs a case at all its phases in one orientation. The same placements for all `settings`.
std::vector<Errors> measure(const Case& case_, const Orientation& orientation, const Settings& settings);

}  // namespace voxcone::test
