% Union, intersection and difference of a cube and a sphere, side by side.
{ /b /g /r { /v /u /face r g b point 1.0 0.0 1.0 } } /matte
1.0 0.3 0.2 matte apply cube -0.5 -0.5 -0.5 translate /a
0.2 0.5 1.0 matte apply sphere 0.62 uscale /b
{ /x { 25.0 rotatex 35.0 rotatey x 0.0 2.4 translate } } /place
a b union -1.4 place apply apply
a b intersect 0.0 place apply apply union
a b difference 1.4 place apply apply union /scene
1.0 -1.0 2.0 point 0.8 0.8 0.8 point light /sun
0.2 0.2 0.2 point [ sun ] scene 0 60.0 64 48 "csg.ppm" render
