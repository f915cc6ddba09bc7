// JSON -> any struct with a field table (scene/fields.h). Each invalid field adds a FieldError with
// its JSON Pointer; reading continues, so that up to kMaxFieldErrors errors are reported at once.
// The member of an invalid field keeps its value.
#pragma once

#include "scene/fields.h"
#include "scene/geometry.h"
#include "scene/spelling.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>
#include <variant>

namespace clerestory {

// RFC 6901. Long names and pointers are truncated, because they come from the client.
inline std::string joinedPointer(const std::string& pointer, std::string_view name) {
    constexpr std::size_t kMaxLength = 512;
    if (pointer.size() > kMaxLength) return pointer;
    std::string text = pointer + "/";
    for (const char c : name.substr(0, 64)) {
        if (c == '~') {
            text += "~0";
        } else if (c == '/') {
            text += "~1";
        } else {
            text += c;
        }
    }
    return text;
}

class FieldReader {
public:
    explicit FieldReader(std::vector<FieldError>& errors) : errors_(errors) {}

    // `known`: members that the caller reads.
    template <class S>
    void object(const nlohmann::json& value, S& target, const std::string& pointer,
                std::vector<std::string_view> known = {}) {
        if (!value.is_object()) {
            refuse(pointer, typed(value), "an object");
            return;
        }
        fields(target,
               [&](const char* name, auto& member, const auto& kind, const char* /*words*/) {
                   known.push_back(name);
                   const auto found = value.find(name);
                   if (found == value.end()) {
                       if constexpr (field::isRequired<std::decay_t<decltype(kind)>>) {
                           // null is wrong for every kind; the error lists what is allowed.
                           const std::size_t before = errors_.size();
                           this->member(nullptr, member, kind, pointer + "/" + name);
                           if (errors_.size() > before) errors_.back().detail = "is missing";
                       }
                       return;
                   }
                   if constexpr (field::Unwrap<std::decay_t<decltype(member)>>::optional) {
                       this->optionalMember(*found, member, kind, pointer + "/" + name);
                   } else {
                       this->member(*found, member, kind, pointer + "/" + name);
                   }
               });
        for (const auto& item : value.items()) {
            if (isFull()) return;
            if (std::find(known.begin(), known.end(), item.key()) == known.end()) {
                refuse(joinedPointer(pointer, item.key()),
                       "is not a known field" + didYouMean(item.key(), known), listed(known));
            }
        }
    }

private:
    static std::string typed(const nlohmann::json& value) {
        return std::string("is ") + value.type_name();
    }

    bool isFull() const { return errors_.size() >= kMaxFieldErrors; }

    void refuse(std::string pointer, std::string detail, std::string allowed) {
        if (isFull()) return;
        errors_.push_back({std::move(pointer), std::move(detail), std::move(allowed)});
    }

    // An optional member is set by a valid value only.
    template <class T, class K>
    void optionalMember(const nlohmann::json& value, std::optional<T>& target, const K& kind,
                        const std::string& pointer) {
        T inner = target.value_or(T{});
        const std::size_t before = errors_.size();
        member(value, inner, kind, pointer);
        if (errors_.size() == before) target = std::move(inner);
    }

    template <class T>
    void member(const nlohmann::json& value, T& target, const Range& range,
                const std::string& pointer) {
        if constexpr (field::components<T> == 1) {
            if (const auto read = number<T>(value, range, pointer)) target = static_cast<T>(*read);
        } else {
            if (!value.is_array() || value.size() != field::components<T>) {
                refuse(pointer,
                       value.is_array() ? "has " + std::to_string(value.size()) + " elements"
                                        : typed(value),
                       field::allowedText<T>(range));
                return;
            }
            for (std::size_t i = 0; i < field::components<T>; ++i) {
                const auto read =
                    number<double>(value[i], range, pointer + "/" + std::to_string(i));
                if (read) target[static_cast<int>(i)] = *read;
            }
        }
    }

    // Checked as double, before narrowing.
    template <class T>
    std::optional<double> number(const nlohmann::json& value, const Range& range,
                                 const std::string& pointer) {
        if (!value.is_number()) {
            refuse(pointer, typed(value), field::allowedText<T>(range));
            return std::nullopt;
        }
        const double read = value.get<double>();
        if (!std::isfinite(read) || read < range.min || read > range.max) {
            refuse(pointer, "is out of range", field::allowedText<T>(range));
            return std::nullopt;
        }
        if (field::isWhole<T> && read != std::floor(read)) {
            refuse(pointer, "is not a whole number", field::allowedText<T>(range));
            return std::nullopt;
        }
        return read;
    }

    void member(const nlohmann::json& value, Quaternion& target, const Rotation&,
                const std::string& pointer) {
        const Range numbers{-1e3, 1e3};
        std::vector<double> read;
        if (value.is_array() && value.size() <= 9) {
            for (std::size_t i = 0; i < value.size(); ++i) {
                const auto one =
                    number<double>(value[i], numbers, pointer + "/" + std::to_string(i));
                if (!one) return;
                read.push_back(*one);
            }
        }
        if (const auto rotation = rotationFrom(read))
            target = *rotation;
        else
            refuse(pointer, value.is_array() ? "is not a rotation" : typed(value), kRotationForms);
    }

    void member(const nlohmann::json& value, std::string& target, const Text& kind,
                const std::string& pointer) {
        const std::string allowed = "at most " + std::to_string(kind.maxLength) + " bytes of text";
        if (!value.is_string()) {
            refuse(pointer, typed(value), allowed);
        } else if (value.get_ref<const std::string&>().size() > kind.maxLength) {
            refuse(pointer, "is too long", allowed);
        } else {
            target = value.get<std::string>();
        }
    }

    void member(const nlohmann::json& value, bool& target, const Flag&,
                const std::string& pointer) {
        if (value.is_boolean()) {
            target = value.get<bool>();
        } else {
            refuse(pointer, typed(value), "true or false");
        }
    }

    template <class E>
    void member(const nlohmann::json& value, E& target, const Choice<E>& choice,
                const std::string& pointer) {
        const std::string allowed = "one of: " + listed(field::wordsOf(choice));
        if (!value.is_string()) {
            refuse(pointer, typed(value), allowed);
            return;
        }
        const auto& word = value.get_ref<const std::string&>();
        for (const auto& [candidate, meaning] : choice.words) {
            if (candidate == word) {
                target = meaning;
                return;
            }
        }
        refuse(pointer, "is not a known word" + didYouMean(word, field::wordsOf(choice)), allowed);
    }

    template <class E, std::size_t N>
    void member(const nlohmann::json& value, std::variant<E, std::array<double, N>>& target,
                const ChoiceOrNumbers<E>& kind, const std::string& pointer) {
        if (value.is_string()) {
            E word{};
            member(value, word, kind.choice, pointer);
            target = word;
        } else if (value.is_array()) {
            std::array<double, N> numbers{};
            member(value, numbers, kind.range, pointer);
            target = numbers;
        } else {
            refuse(pointer, typed(value),
                   "one of: " + listed(field::wordsOf(kind.choice)) + "; or " +
                       field::allowedText<std::array<double, N>>(kind.range));
        }
    }

    template <class T>
    void member(const nlohmann::json& value, T& target, const TextOrList& kind,
                const std::string& pointer) {
        if (value.is_array()) {
            elements(value, target.parts, kind.maxItems, Nested{}, pointer);
            if (value.empty()) refuse(pointer, "is empty", "at least one scene");
            if (!target.parts.empty()) target.id = target.parts.front().scene;
        } else if (value.is_string()) {
            target.parts.clear();
            member(value, target.id, kind.text, pointer);
        } else {
            refuse(pointer, typed(value),
                   "an id, or a list of at most " + std::to_string(kind.maxItems) + " scenes");
        }
    }

    template <class S>
    void member(const nlohmann::json& value, S& target, const Nested&, const std::string& pointer) {
        object(value, target, pointer);
    }

    template <class T, class K>
    void member(const nlohmann::json& value, T& target, const Required<K>& required,
                const std::string& pointer) {
        member(value, target, required.kind, pointer);
    }

    template <class S>
    void member(const nlohmann::json& value, std::vector<S>& target, const NestedList& list,
                const std::string& pointer) {
        elements(value, target, list.maxItems, Nested{}, pointer);
    }

    template <class S>
    void member(const nlohmann::json& value, std::vector<S>& target, const NestedPresetList& list,
                const std::string& pointer) {
        elements(value, target, list.maxItems, NestedPreset{}, pointer);
    }

    template <class... S>
    void member(const nlohmann::json& value, std::vector<std::variant<S...>>& target,
                const NestedUnionList& list, const std::string& pointer) {
        elements(value, target, list.maxItems, list, pointer);
    }

    template <class... S>
    void member(const nlohmann::json& value, std::variant<S...>& target, const NestedUnionList&,
                const std::string& pointer) {
        member(value, target, NestedUnion{}, pointer);
    }

    template <class... S>
    void member(const nlohmann::json& value, std::variant<S...>& target, const NestedUnion&,
                const std::string& pointer) {
        const std::vector<std::string_view> types{S::kType...};
        const std::string at = pointer + "/type", allowed = "one of: " + listed(types);
        if (!value.is_object()) return refuse(pointer, typed(value), "an object");
        const auto type = value.find("type");
        if (type == value.end()) return refuse(at, "is missing", allowed);
        if (!type->is_string()) return refuse(at, typed(*type), allowed);
        const auto& word = type->template get_ref<const std::string&>();
        if (!(alternative<S>(value, word, target, pointer) || ...)) {
            refuse(at, "is not a known word" + didYouMean(word, types), allowed);
        }
    }

    // Reads `value` as an S if that is its type.
    template <class S, class Union>
    bool alternative(const nlohmann::json& value, std::string_view type, Union& target,
                     const std::string& pointer) {
        if (type != S::kType) return false;
        S read;
        object(value, read, pointer, {"type"});
        target = std::move(read);
        return true;
    }

    template <class S, class K>
    void elements(const nlohmann::json& value, std::vector<S>& target, std::size_t maxItems,
                  const K& kind, const std::string& pointer) {
        const std::string allowed = "a list of at most " + std::to_string(maxItems);
        if (!value.is_array()) return refuse(pointer, typed(value), allowed);
        if (value.size() > maxItems) {
            return refuse(pointer, "has " + std::to_string(value.size()) + " elements", allowed);
        }
        target.assign(value.size(), S{});
        for (std::size_t i = 0; i < target.size() && !isFull(); ++i) {
            member(value[i], target[i], kind, pointer + "/" + std::to_string(i));
        }
    }

    // A preset's name, or an object that starts from a preset and changes single settings.
    template <class S>
    void member(const nlohmann::json& value, S& target, const NestedPreset&,
                const std::string& pointer) {
        const auto presets = presetsOf(target);
        if (!value.is_string() && !value.is_object()) {
            return refuse(
                pointer, typed(value),
                "one of: " + listed(field::wordsOf(presets)) + "; or an object of settings");
        }
        auto preset = target.preset;
        if (value.is_string()) {
            member(value, preset, presets, pointer);
            target = ofPreset(target, preset);
            return;
        }
        if (const auto found = value.find("preset"); found != value.end() && found->is_string()) {
            for (const auto& [word, meaning] : presets.words) {
                if (word == found->template get_ref<const std::string&>()) preset = meaning;
            }
        }
        target = ofPreset(target, preset);
        object(value, target, pointer);
    }

    std::vector<FieldError>& errors_;
};

}  // namespace clerestory
