% a solid that is given twice is met twice
%
% Pairs of pictures of what set theory says is the same.
#include "common.gml"

orange matte apply cube -0.5 -0.5 -0.5 translate 1.2 uscale 20.0 rotatex /a
orange matte apply sphere 0.7 uscale 0.4 0.3 -0.4 translate /b
orange matte apply cylinder 0.0 -0.5 0.0 translate 0.35 3.0 0.35 scale 70.0 rotatez /c
{ /name /object object 25.0 rotatey 0.0 0.0 1.5 translate name sunny apply } /shown
a b c union difference "a-(b+c).ppm" shown apply
a b difference c difference "(a-b)-c.ppm" shown apply
a b c union intersect "a(b+c).ppm" shown apply
a b intersect a c intersect union "ab+ac.ppm" shown apply
a "a.ppm" shown apply
a b difference a b intersect union "(a-b)+ab.ppm" shown apply
a a b difference difference "a-(a-b).ppm" shown apply
a b intersect "ab.ppm" shown apply
a b union "a+b.ppm" shown apply
b a b difference union a union "b+(a-b)+a.ppm" shown apply
a b c intersect union "a+bc.ppm" shown apply
a b union a c union intersect "(a+b)(a+c).ppm" shown apply
