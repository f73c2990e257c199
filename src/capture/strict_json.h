// JSON that a user wrote: every key is checked, and messages name file, JSON path and reason.
#pragma once

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace voxcone {

/// Metres, watts, seconds: beyond that single precision has nothing left.
constexpr double kLargest = 1e9;

/// Parses `text`. Syntax errors (with line and column) and keys that stand twice are InputErrors of `file`.
nlohmann::json parseStrictly(const std::string& text, const std::string& file);

/// "a string", "an array", "null".
std::string jsonKind(const nlohmann::json& value);

/// One object of a script. Every look-up is noted, so that `finish` can refuse what nobody asked for. All failures are
/// InputErrors of `file` at `path`. The tree must outlive it.
class JsonObject {
  public:
    /// Fails when `tree` is no object.
    JsonObject(const nlohmann::json& tree, std::string file, std::string path);

    /// JSON path of a key of this object; of the object itself for "".
    std::string pathOf(const std::string& key) const;
    const std::string& file() const { return file_; }

    [[noreturn]] void fail(const std::string& key, const std::string& reason) const;

    /// The value of `key`, or null when it is absent.
    const nlohmann::json* find(const std::string& key);
    const nlohmann::json& require(const std::string& key);

    /// `otherwise` where the key is absent.
    bool boolean(const std::string& key, bool otherwise);
    double number(const std::string& key, double otherwise, double min, double max, const char* unit = "");
    int integer(const std::string& key, int otherwise, int min, int max);
    glm::dvec3 vectorOr(const std::string& key, const glm::dvec3& otherwise, double min, double max);

    /// Fail where the key is absent.
    std::string string(const std::string& key);
    double requiredNumber(const std::string& key, double min, double max, const char* unit = "");
    glm::dvec3 vector(const std::string& key, double min, double max);
    glm::dvec3 direction(const std::string& key);  ///< unit; fails for zero
    glm::vec3 color(const std::string& key);       ///< radiometric, not negative: three numbers, or one for grey

    /// Place in `words` of the string at `key`; fails for other words and names the nearest. `what` they are: "light".
    std::size_t word(const std::string& key, const std::vector<std::string>& words, const std::string& what);

    /// Call last: fails for the first key that was never looked up.
    void finish() const;

  private:
    const nlohmann::json& tree_;
    std::string file_, path_;
    std::vector<std::string> known_;
};

}  // namespace voxcone
