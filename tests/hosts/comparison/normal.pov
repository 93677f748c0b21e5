// The normals of `scene-000000.pov`, a scene that `relievo scene export pov` wrote, as colours (1 + N) / 2:
// povray +Inormal.pov +L<folder of the scene> +FN16 +UA File_Gamma=1
#version 3.7;
// POV-Ray's slope is the angle to an axis, from 0 to 1; the map makes it the cosine again, to 2e-5.
#macro Along(Axis)
  slope { Axis }
  color_map {
    #for (Step, 0, 255)
      [Step / 255 rgb 3 * Axis * (0.5 + 0.5 * sin((Step / 255 - 0.5) * pi))]
    #end
  }
#end
#declare Normals = texture {
  pigment { average pigment_map { [1 Along(x)] [1 Along(y)] [1 Along(z)] } }
  finish { ambient 0 diffuse 0 emission 1 }
}
#macro Surface_Texture(Color, Specular, Roughness)
  texture { Normals }
#end
#include "scene-000000.pov"
