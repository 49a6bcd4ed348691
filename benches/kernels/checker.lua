local floor = math.floor
local light_tile, dark_tile = { 0.9, 0.8, 0.6 }, { 0.2, 0.1, 0.1 }
local tiles = {
  { light_tile, dark_tile, light_tile },
  { dark_tile, light_tile, dark_tile },
  { light_tile, dark_tile, light_tile },
}

return function(face, u, v)
  local tile = tiles[floor(v * 3.0) + 1][floor(u * 3.0) + 1]
  return tile[1], tile[2], tile[3], 0.8, 0.2, 6.0
end
