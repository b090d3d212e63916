// SPDX-License-Identifier: Apache-2.0
// A clock in a worker: browsers slow down the timers of pages in the background, but not this one.
setInterval(() => postMessage(0), 150);
