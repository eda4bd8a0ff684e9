/* The class of C++17 along a table of samples; a copy made in the middle goes on to the same end. */
#include <cstdio>
#include <type_traits>

#include "brushgrip.hpp"

static_assert(std::is_nothrow_default_constructible_v<brushgrip::Observer>);
static_assert(std::is_trivially_copyable_v<brushgrip::Observer>);
static_assert(sizeof(brushgrip::Observer) == sizeof(brushgrip_state_t));

int main() {
    brushgrip::Observer observer, copy;
    brushgrip::Sample empty;
    if (!has(observer.step(empty), brushgrip::Status::refused)) return 1;
    observer.reset();
    double t, psi, torque;
    for (int i = 0; std::scanf("%lf,%lf,%lf", &t, &psi, &torque) == 3; ++i) {
        brushgrip::Sample sample;
        sample.psi = psi;
        sample.M_z = torque;
        sample.F_N = 400.0;
        sample.dt = 0.01;
        const auto status = observer.step(sample);
        if (i >= 150) copy.step(sample);
        if (i == 149) copy = observer;
        const auto now = observer.estimate();
        if (static_cast<std::int32_t>(status) != now.status || observer.informed() != (now.informed != 0)) return 2;
        std::printf("%.17g %.17g %d\n", now.mu, now.mu_std, now.status);
    }
    return copy.estimate().mu == observer.estimate().mu ? 0 : 3;
}
