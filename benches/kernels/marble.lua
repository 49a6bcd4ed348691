local sin, cos = math.sin, math.cos
local radians = math.pi / 180.0

return function(face, u, v)
  local x, y = u * 6.0, v * 4.0
  local coarse = sin((x * 67.0 + y * 31.0) * radians)
  local fine = cos((y * 113.0 - x * 47.0 + coarse * 40.0) * radians)
  local wave = sin(((x + y) * 90.0 + coarse * 75.0 + fine * 25.0) * radians)
  local calm = 1.0 - wave * wave
  local square = calm * calm
  local vein = square * square
  local cloud = cos(((x - y) * 130.0 + fine * 60.0) * radians) * 0.5 + 0.5
  local soft = cloud * cloud * (3.0 - cloud * 2.0)
  local t = vein * 0.7 + soft * 0.3
  if t < 0.0 then t = 0.0 elseif t > 1.0 then t = 1.0 end
  local rest = 1.0 - t
  return t * 0.92 + rest * 0.20, t * 0.88 + rest * 0.16, t * 0.80 + rest * 0.24,
    t * 0.35 + 0.55, 0.45 - t * 0.25, t * 18.0 + 6.0
end
