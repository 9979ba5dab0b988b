// Options as JSON.
#ifndef CRANNY_DETAIL_OPTIONS_HPP
#define CRANNY_DETAIL_OPTIONS_HPP

#include <cstddef>
#include <cstdio>
#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace cranny {

/// Options with the keywords of the Python package: a list of pairs, or JSON.
///
///   cranny::plan(scenario, {{"seed", 7}, {"time_limit_s", 2.0}, {"planner", "reach"}});
///   cranny::plan(scenario, R"({"carry": "home", "speed": {"carry": 0.5}})");
class Options {
 public:
  /// A value: a boolean, a number, a text or numbers.
  class Value {
   public:
    Value(bool value) : json_(value ? "true" : "false") {}
    Value(double value) : json_(number(value)) {}
    template <class I, class = std::enable_if_t<std::is_integral_v<I> && !std::is_same_v<I, bool>>>
    Value(I value) : json_(std::to_string(value)) {}
    Value(const char* value) : json_(quoted(value)) {}
    Value(const std::string& value) : json_(quoted(value)) {}
    Value(const std::vector<double>& values) : json_("[") {
      for (std::size_t i = 0; i < values.size(); ++i) json_ += (i ? "," : "") + number(values[i]);
      json_ += "]";
    }
    const std::string& json() const { return json_; }

   private:
    // JSON has no infinity and no NaN; the library then refuses the text.
    static std::string number(double value) {
      char text[32];
      std::snprintf(text, sizeof text, "%.17g", value);
      return text;
    }
    std::string json_;
  };

  Options() = default;
  Options(const char* json) : json_(json) {}
  Options(const std::string& json) : json_(json) {}
  Options(std::initializer_list<std::pair<const char*, Value>> pairs) {
    for (const auto& [name, value] : pairs) json_ += (json_.empty() ? "{" : ",") + quoted(name) + ":" + value.json();
    if (!json_.empty()) json_ += "}";
  }

  /// JSON for the C API, or NULL for the defaults.
  const char* c_str() const { return json_.empty() ? nullptr : json_.c_str(); }

 private:
  static std::string quoted(const std::string& text) {
    std::string json = "\"";
    for (const char c : text) {
      if (c == '"' || c == '\\') json += '\\';
      if (static_cast<unsigned char>(c) < 0x20) {
        char code[8];
        std::snprintf(code, sizeof code, "\\u%04x", c);
        json += code;
      } else {
        json += c;
      }
    }
    return json + '"';
  }
  std::string json_;
};

}  // namespace cranny

#endif
