// SPDX-License-Identifier: Apache-2.0
// How deep bones lie under the skin of adults, from published measurements.
#pragma once

namespace ndg {

/// Levels of the spine for spinous_depth: C7 is 0, T1 to T12 are 1 to 12, L1 to L5 are 13 to 17.
constexpr int level_c7 = 0, level_t1 = 1, level_t12 = 12, level_l1 = 13, level_l5 = 17;

/// Depth of the tip of a spinous process under the skin of the back's midline, m. `level` may lie between two levels.
///   lumbar    means 22.8, 23.0, 27.4, 33.4 and 36.7 mm of L1 to L5 at a mean body mass index of 27.2 (Kawchuk et al.
///             2011, Manual Therapy 16, 374-378, MRI of 105 adults, where depth grows linearly with the index); the
///             slope, 0.98 mm per kg/m^2, is that from skin to the epidural space (Ravi et al. 2011, 17.8 + 0.978 BMI),
///             from which the tips differ by the length of bone
///   thoracic  no mean is published: 16 to 18 mm at 27.2, as far as fat of the back (mean 17 mm, at an index of 46
///             50.7 mm; CT of 649 and of 55 adults, doi 10.1186/s13104-017-2918-9) and half its slope, for over the
///             processes the skin is held down
///   C7        grows with the index (Piche et al. 2023, r = 0.58), taken as T1
/// At least 6 mm: skin and supraspinous ligament.
double spinous_depth(double level, double bmi);

/// Depth of the front of the breastbone under the skin of the midline, m: fat at the level of the nipples is 10 mm in
/// the mean and 36.5 mm at an index of 46 (CT, as above), over the bone less, taken as 8 mm at 27.2 and a third of that
/// growth.
double sternum_depth(double bmi);

/// Depth of the sides of the rib cage below the armpits and of the iliac crests, m: fat, and over the ribs serratus and
/// latissimus. The front of the crest (ASIS) lies 9.7 +- 7.0 mm deep in 67 adults, growing with the index (Mantovani et
/// al. 2016); taken as 20 mm at 27.2 and 0.9 mm per kg/m^2, as at the back.
double rib_side_depth(double bmi);

}  // namespace ndg
