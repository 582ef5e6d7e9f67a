#pragma once

#include <cstdint>
#include <vector>

#include "eval/evaluation_object.h"

namespace prehend::eval {

/// Scenes drawn from `seed`, so that there are as many as one likes that nobody has looked at: 18 a
/// seed, of the solids of varied_shapes.h,
///  - six bodies alone, 3 to 30 cm, each seed other kinds of them;
///  - four pairs side by side, that touch (three) or stand 5 mm apart, of equal or different
///  height;
///  - stacks of two, three and four, whose sides are flush or stepped;
///  - one body that leans on a box, one that lies on one;
///  - one of which something hides about a third, from two opposite sides;
///  - one cut by the image's frame;
///  - one of 9 to 20 mm and one of 35 to 60 cm;
/// seen by stereo or structured light from 15 to 75 degrees over the table. Of bodies that are
/// together a third have one colour, a third similar ones, a third colours of their own. Which of
/// them is the scene's object is drawn, too. The same for every machine. Cost: about two seconds.
std::vector<EvaluationObject> varied_scenes(std::uint64_t seed);

}  // namespace prehend::eval
