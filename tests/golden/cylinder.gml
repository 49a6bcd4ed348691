% The side and the bottom of a cylinder.
{ /v /u /face face 0 eqi { u v 0.0 point } { face 1 eqi { 1.0 u v point } { u 1.0 v point } if } if 1.0 0.0 1.0 }
cylinder 0.0 -0.5 0.0 translate 30.0 rotatey 40.0 rotatex 0.0 0.0 2.5 translate /scene
1.0 1.0 1.0 point [] scene 0 60.0 64 48 "cylinder.ppm" render
