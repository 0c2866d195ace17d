// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace ndg {

/// From now on SIGTERM, SIGINT and SIGUSR1 set a flag instead of ending the process at once.
void catch_interrupts();
/// True once such a signal has arrived; long loops finish the sample at hand and throw Interrupted.
bool interrupt_requested();

}  // namespace ndg
