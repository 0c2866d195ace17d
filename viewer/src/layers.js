// SPDX-License-Identifier: Apache-2.0
// What can be shown, from outside to inside, and how it looks.

/** `cut`: colour of the cut face; `solid`: what it fills (see Stage). Colours are sRGB. */
export const layers = [
  { id: 'skin', label: 'Skin', colour: '#d9b79f', cut: '#c99c84', gloss: 0.16, opacity: 0.4 },
  { id: 'fat', label: 'Fat', colour: '#e4c77c', cut: '#ecd591', gloss: 0.22, opacity: 1, shown: false },
  { id: 'muscle_wrap', label: 'Muscle wrap', colour: '#b0544a', cut: '#b4574c', gloss: 0.3, opacity: 1, shown: false },
  { id: 'muscles', label: 'Muscles', colour: '#a5433b', cut: '#8f3029', gloss: 0.32, opacity: 1, anatomy: true },
  { id: 'bone_wrap', label: 'Bone wrap', colour: '#cdb48a', cut: '#c9a98a', gloss: 0.15, opacity: 1, shown: false },
  { id: 'bones', label: 'Bones', colour: '#e6dcc3', cut: '#f4ecd6', gloss: 0.2, opacity: 1, anatomy: true },
];

/** Order in which cut faces are painted, each over the ones before. */
export const cutOrder = ['skin', 'fat', 'muscle_wrap', 'bone_wrap', 'muscles', 'bones'];

export const highlightColour = '#3fa7d6';
