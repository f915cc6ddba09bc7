#include "scene/import/base/json_text.h"

#include "scene/import/base/field_reader.h"

#include <optional>

namespace clerestory {
namespace {

using nlohmann::json;

class Builder : public nlohmann::json_sax<json> {
public:
    Builder(std::size_t maxDepth, std::vector<std::string>* doubled, const JsonSizes& sizes)
        : maxDepth_(maxDepth), doubled_(doubled), sizes_(sizes) {}

    bool null() override { return add(nullptr); }
    bool boolean(bool value) override { return add(value); }
    bool number_integer(number_integer_t value) override { return add(value); }
    bool number_unsigned(number_unsigned_t value) override { return add(value); }
    bool number_float(number_float_t value, const string_t&) override { return add(value); }
    bool string(string_t& value) override { return add(std::move(value)); }
    bool binary(binary_t& value) override { return add(std::move(value)); }
    bool start_object(std::size_t) override { return open(json::object()); }
    bool start_array(std::size_t) override { return open(json::array()); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }

    bool key(string_t& name) override {
        Level& level = levels_.back();
        level.key = std::move(name);
        if (!doubled_ || !level.value->contains(level.key)) return true;
        doubled_->push_back(pointer());
        return doubled_->size() < kMaxFieldErrors;
    }

    bool parse_error(std::size_t byte, const std::string&,
                     const nlohmann::detail::exception& error) override {
        constexpr int kNumberOutOfRange = 406;
        const bool isNumber = error.id == kNumberOutOfRange;
        error_.emplace(isNumber ? JsonTextError::Kind::numberRange : JsonTextError::Kind::syntax,
                       byte, isNumber ? pointer() : "");
        return false;
    }

    const std::optional<JsonTextError>& error() const { return error_; }
    json& value() { return root_; }

private:
    struct Level {
        json* value;
        std::string key;  // of an object: its last one
    };

    bool fail(JsonTextError::Kind kind, std::string pointer) {
        error_.emplace(kind, 0, std::move(pointer));
        return false;
    }

    // Whether the next value is within the limits.
    bool hasRoom() {
        if (++values_ > sizes_.values) return fail(JsonTextError::Kind::values, "");
        if (levels_.empty() || !levels_.back().value->is_array()) return true;
        if (levels_.back().value->size() < sizes_.elements) return true;
        levels_.pop_back();  // the pointer is that of the list
        return fail(JsonTextError::Kind::elements, pointerOfOpen());
    }

    // Its address is valid until the next value of the same list or object is added.
    json* put(json&& value) {
        if (levels_.empty()) return &(root_ = std::move(value));
        Level& level = levels_.back();
        if (level.value->is_array()) return &level.value->emplace_back(std::move(value));
        return &((*level.value)[level.key] = std::move(value));
    }
    bool add(json value) {
        if (!hasRoom()) return false;
        put(std::move(value));
        return true;
    }
    bool open(json value) {
        if (levels_.size() == maxDepth_) return fail(JsonTextError::Kind::depth, "");
        if (!hasRoom()) return false;
        levels_.push_back({put(std::move(value)), {}});
        return true;
    }
    bool close() {
        levels_.pop_back();
        return true;
    }

    // Of the value that comes next.
    std::string pointer() const { return pointerTo(true); }
    // Of the value that was added last at the innermost level.
    std::string pointerOfOpen() const { return pointerTo(false); }

    std::string pointerTo(bool next) const {
        std::string text;
        for (const Level& level : levels_) {
            const bool isLast = next && &level == &levels_.back();
            const std::size_t index = level.value->size() - (isLast ? 0 : 1);
            text = joinedPointer(text, level.value->is_array() ? std::to_string(index) : level.key);
        }
        return text;
    }

    std::size_t maxDepth_;
    std::vector<std::string>* doubled_;
    const JsonSizes sizes_;
    std::size_t values_ = 0;  // so far
    std::vector<Level> levels_;
    json root_;
    std::optional<JsonTextError> error_;
};

}  // namespace

json jsonFrom(std::string_view text, std::size_t maxDepth, std::vector<std::string>* doubled,
              const JsonSizes& sizes) {
    Builder builder(maxDepth, doubled, sizes);
    json::sax_parse(text, &builder);
    if (builder.error()) throw *builder.error();
    return std::move(builder.value());
}

}  // namespace clerestory
