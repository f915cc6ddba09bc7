// Compilation as it happens: a driver compiles a program when it is linked, and again, without
// being asked, inside the first draw with each combination of program, fixed state and target
// format. llvmpipe takes 0.1 to 1 s for each. This watches both, so that the time is known for what
// it is.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <tuple>

namespace clerestory::gl {

struct CompileCounters {
    std::uint64_t programs = 0;   // linked
    std::uint64_t pipelines = 0;  // combinations that were drawn for the first time
    double milliseconds = 0.0;    // that both took; a draw that found its code in a cache included
};

class FirstUse {
public:
    // Called on the context's thread with true before and with false after each compilation.
    std::function<void(bool begins)> whenCompiling;

    const CompileCounters& counters() const { return counters_; }

    // What the next draw uses. `state` and `target`: any numbers that are equal for equal state.
    void setProgram(std::uint32_t name) { set(program_, name); }
    void setState(std::uint32_t state) { set(state_, state); }
    void setTarget(std::uint32_t target) { set(target_, target); }

    // Runs `call`, which links a program.
    template <class Call>
    auto link(Call&& call) {
        ++counters_.programs;
        const Timed timed(*this);
        return call();
    }
    // Runs `call`, which draws; watches it if it is the first with this combination.
    template <class Call>
    void draw(Call&& call) {
        if (known_) return call();
        known_ = true;
        if (!seen_.emplace(program_, state_, target_).second) return call();
        ++counters_.pipelines;
        const Timed timed(*this);
        call();
    }

private:
    class Timed {
    public:
        explicit Timed(FirstUse& use);
        ~Timed();
        Timed(const Timed&) = delete;
        Timed& operator=(const Timed&) = delete;

    private:
        FirstUse& use_;
        std::int64_t begin_;  // nanoseconds
    };

    void set(std::uint32_t& value, std::uint32_t to) {
        known_ = known_ && value == to;
        value = to;
    }

    std::uint32_t program_ = 0, state_ = 0, target_ = 0;
    bool known_ = false;  // the combination at hand was drawn before
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> seen_;
    CompileCounters counters_;
};

}  // namespace clerestory::gl
