// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/interrupt.h"

#include <csignal>
#include <initializer_list>

namespace ndg {
namespace {

volatile std::sig_atomic_t interrupted = 0;

extern "C" void note_interrupt(int)
{
    interrupted = 1;
}

}  // namespace

void catch_interrupts()
{
    struct sigaction action = {};
    action.sa_handler = note_interrupt;
    sigemptyset(&action.sa_mask);
    // The first signal asks politely; a second of the same kind ends the process at once. Files stay whole either way.
    action.sa_flags = static_cast<int>(SA_RESTART | SA_RESETHAND);
    for (const int signal : {SIGTERM, SIGINT, SIGUSR1}) sigaction(signal, &action, nullptr);
}

bool interrupt_requested()
{
    return interrupted != 0;
}

}  // namespace ndg
