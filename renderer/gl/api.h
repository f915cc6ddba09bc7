// OpenGL's entry points, linked directly from libOpenGL; and the numbers every wrapper shares.
#pragma once

#define GL_GLEXT_PROTOTYPES 1
#include <GL/glcorearb.h>

namespace clerestory::gl {

using Name = unsigned int;  // OpenGL's name of an object; 0 is none

// An object's name with one owner: moved, never copied.
class OwnedName {
public:
    OwnedName() = default;
    explicit OwnedName(Name name) : name_(name) {}
    OwnedName(OwnedName&& other) noexcept : name_(other.name_) { other.name_ = 0; }
    OwnedName(const OwnedName&) = delete;
    OwnedName& operator=(const OwnedName&) = delete;
    OwnedName& operator=(OwnedName&&) = delete;
    Name get() const { return name_; }

private:
    Name name_ = 0;
};

}  // namespace clerestory::gl
