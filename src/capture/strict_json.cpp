#include "capture/strict_json.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.h"
#include "core/nearest.h"

namespace voxcone {

using nlohmann::json;

namespace {

/// "line 3, column 14" of the byte at `offset`.
std::string placeOf(const std::string& text, std::size_t offset) {
    const std::string_view before = std::string_view(text).substr(0, std::min(offset, text.size()));
    const auto lines = std::count(before.begin(), before.end(), '\n');
    const std::size_t lineStart = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
    return fmt::format("line {}, column {}", lines + 1, before.size() - lineStart + 1);
}

/// The reason inside a message of nlohmann's parser, which wraps it in numbers and places of its own.
std::string reasonOf(const json::exception& error) {
    std::string text = error.what();
    if (const auto at = text.find("syntax error"); at != std::string::npos) text = text.substr(at);
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

}  // namespace

json parseStrictly(const std::string& text, const std::string& file) {
    std::vector<std::set<std::string>> open;
    std::string duplicate;
    const auto watch = [&](int, json::parse_event_t event, json& parsed) {
        if (event == json::parse_event_t::object_start) open.emplace_back();
        if (event == json::parse_event_t::object_end) open.pop_back();
        if (event == json::parse_event_t::key && !open.back().insert(parsed.get<std::string>()).second &&
            duplicate.empty())
            duplicate = parsed.get<std::string>();
        return true;
    };
    json tree;
    try {
        tree = json::parse(text, watch);
    } catch (const json::parse_error& error) {
        throw InputError(file, placeOf(text, error.byte == 0 ? 0 : error.byte - 1),
                         "not valid JSON: " + reasonOf(error));
    } catch (const json::exception& error) {
        throw InputError(file, "", "not valid JSON: " + reasonOf(error));
    }
    if (!duplicate.empty()) throw InputError(file, "", fmt::format("key \"{}\" stands twice in one object", duplicate));
    return tree;
}

std::string jsonKind(const json& value) {
    if (value.is_null()) return "null";
    return fmt::format("{} {}", value.is_structured() ? "an" : "a", value.type_name());
}

JsonObject::JsonObject(const json& tree, std::string file, std::string path)
    : tree_(tree), file_(std::move(file)), path_(std::move(path)) {
    if (!tree.is_object()) fail("", fmt::format("must be an object, is {}", jsonKind(tree)));
}

std::string JsonObject::pathOf(const std::string& key) const {
    return key.empty() ? path_ : path_.empty() ? key : path_ + "." + key;
}

void JsonObject::fail(const std::string& key, const std::string& reason) const {
    throw InputError(file_, pathOf(key), reason);
}

const json* JsonObject::find(const std::string& key) {
    if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
    const auto found = tree_.find(key);
    return found == tree_.end() ? nullptr : &*found;
}

const json& JsonObject::require(const std::string& key) {
    const json* value = find(key);
    if (value == nullptr) fail(key, "is missing");
    return *value;
}

bool JsonObject::boolean(const std::string& key, bool otherwise) {
    const json* value = find(key);
    if (value == nullptr) return otherwise;
    if (!value->is_boolean()) fail(key, fmt::format("must be true or false, is {}", jsonKind(*value)));
    return value->get<bool>();
}

double JsonObject::number(const std::string& key, double otherwise, double min, double max, const char* unit) {
    const json* value = find(key);
    if (value == nullptr) return otherwise;
    if (!value->is_number()) fail(key, fmt::format("must be a number, is {}", jsonKind(*value)));
    const double number = value->get<double>();
    if (!(number >= min && number <= max))
        fail(key,
             fmt::format("{} is out of range: {} to {}{}{}", value->dump(), min, max, *unit == 0 ? "" : " ", unit));
    return number;
}

int JsonObject::integer(const std::string& key, int otherwise, int min, int max) {
    const double value = number(key, otherwise, min, max);
    if (value != std::floor(value)) fail(key, "must be a whole number");
    return static_cast<int>(value);
}

glm::dvec3 JsonObject::vectorOr(const std::string& key, const glm::dvec3& otherwise, double min, double max) {
    return tree_.contains(key) ? vector(key, min, max) : (find(key), otherwise);
}

std::string JsonObject::string(const std::string& key) {
    const json& value = require(key);
    if (!value.is_string()) fail(key, fmt::format("must be a string, is {}", jsonKind(value)));
    return value.get<std::string>();
}

double JsonObject::requiredNumber(const std::string& key, double min, double max, const char* unit) {
    if (!tree_.contains(key)) fail(key, "is missing");
    return number(key, 0, min, max, unit);
}

glm::dvec3 JsonObject::vector(const std::string& key, double min, double max) {
    const json& value = require(key);
    if (!value.is_array() || value.size() != 3) fail(key, "must be an array of 3 numbers");
    glm::dvec3 out;
    for (glm::length_t i = 0; i < 3; ++i) {
        const json& component = value[static_cast<std::size_t>(i)];
        const std::string at = fmt::format("{}[{}]", key, i);
        if (!component.is_number()) fail(at, fmt::format("must be a number, is {}", jsonKind(component)));
        out[i] = component.get<double>();
        if (!(out[i] >= min && out[i] <= max))
            fail(at, fmt::format("{} is out of range: {} to {}", component.dump(), min, max));
    }
    return out;
}

glm::dvec3 JsonObject::direction(const std::string& key) {
    const glm::dvec3 out = vector(key, -kLargest, kLargest);
    if (glm::length(out) < 1e-9) fail(key, "must not be zero");
    // What is unit already keeps its bits, so that what is written comes back.
    return std::abs(glm::dot(out, out) - 1) < 4e-15 ? out : glm::normalize(out);
}

glm::vec3 JsonObject::color(const std::string& key) {
    if (const json* value = find(key); value != nullptr && value->is_number())
        return glm::vec3(static_cast<float>(number(key, 0, 0, kLargest)));
    return glm::vec3(vector(key, 0, kLargest));
}

std::size_t JsonObject::word(const std::string& key, const std::vector<std::string>& words, const std::string& what) {
    const std::string text = string(key);
    const auto found = std::find(words.begin(), words.end(), text);
    if (found == words.end())
        fail(key, fmt::format("\"{}\" is no {}; did you mean \"{}\"? (there are {})", text, what,
                              nearestWord(words, text), fmt::join(words, ", ")));
    return static_cast<std::size_t>(found - words.begin());
}

void JsonObject::finish() const {
    for (const auto& [key, value] : tree_.items()) {
        if (std::find(known_.begin(), known_.end(), key) == known_.end())
            fail(key, fmt::format("unknown key; did you mean \"{}\"? (there are {})", nearestWord(known_, key),
                                  fmt::join(known_, ", ")));
    }
}

}  // namespace voxcone
