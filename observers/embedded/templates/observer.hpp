/* ${title}
   For C++17, around the C of ${name}.c, which stays C: the same numbers, no heap, no exceptions.

       ${name}::Observer observer;
       ${name}::Sample sample;  // NAN until a sensor gives a value
       sample.psi = angle;
       sample.dt = 0.01;
       if (ok(observer.step(sample)) && observer.usable()) use(observer.estimate().mu_eff);

   ${generated} */
#ifndef ${NAME}_HPP
#define ${NAME}_HPP

#include <cstdint>
#include <limits>

#include "${name}.h"

namespace ${name} {

/* Status of a sample; several flags may be set. */
enum class Status : std::int32_t {
    used = ${NAME}_USED,
    ${flag|lower} = ${NAME}_${flag}, /* ${remedy} */ %% for flag, number, remedy in flags
};

/* Whether all flags of a part are set. */
[[nodiscard]] constexpr bool has(Status status, Status part) noexcept {
    return (static_cast<std::int32_t>(status) & static_cast<std::int32_t>(part)) == static_cast<std::int32_t>(part);
}

/* Whether the sample's torque was used. */
[[nodiscard]] constexpr bool ok(Status status) noexcept { return status == Status::used; }

/* One sample of the sensors, units as in ${name}.h; NAN until a value is set, dt too. */
struct Sample : ${name}_sample_t {
    Sample() noexcept : ${name}_sample_t{missing(), missing(), missing(), missing(), missing()} {}
    static constexpr ${real} missing() noexcept { return std::numeric_limits<${real}>::quiet_NaN(); }
};

using Estimate = ${name}_estimate_t;
using Parameters = ${name}_parameters_t; %% if tunable

/* One observer, of fixed size; a copy goes on from the same state by itself. For one thread at a time. */
class Observer {
public:
    Observer() noexcept { ${name}_init(&state_); }

    /* Advances by one sample. */
    Status step(const ${name}_sample_t &sample) noexcept {
        return static_cast<Status>(${name}_step(&state_, &sample));
    }

    /* The estimate after the last sample. */
    [[nodiscard]] Estimate estimate() const noexcept {
        Estimate now{};
        ${name}_estimate(&state_, &now);
        return now;
    }

    /* False while the estimate rests on the prior. */
    [[nodiscard]] bool informed() const noexcept { return estimate().informed != 0; }

    /* True where a controller may act on mu_eff: informed by the last sample, and no flag is set. */
    [[nodiscard]] bool usable() const noexcept { return estimate().usable != 0; }

    /* Back to the state of a new observer, as when the car has driven since. */
    void reset() noexcept { ${name}_reset(&state_); }

%% if tunable
    /* Other parameters, at any time: 0, or the place of the first that is out of range; then nothing changes. */
    [[nodiscard]] std::int32_t set_parameters(const Parameters &parameters) noexcept {
        return ${name}_set_parameters(&state_, &parameters);
    }

%% endif
    [[nodiscard]] static const char *version() noexcept { return ${name}_version(); }

private:
    ${name}_state_t state_;
};

}  // namespace ${name}

#endif
