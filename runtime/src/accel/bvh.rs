//! Trees of boxes: obvhs builds them, here they become the nodes that kernels/geometry.h reads.
//!
//! In: corners of triangles or boxes of instances, camera-relative or in object space. Out: 16 floats a node, appended to one
//! array, and the order of the leaves. It must not know meshes, materials or devices.

use super::Error;
use crate::choices::TreeQuality;
use glam::{DVec3, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::{build_bvh2, build_bvh2_from_tris};
use obvhs::triangle::Triangle;
use obvhs::{Boundable, BvhBuildParams};
use std::time::Duration;

/// Floats of a node.
pub(super) const NODE_FLOATS: usize = 16;

/// Deepest tree that the kernels' stack holds, both levels together (STACK_SIZE of kernels/geometry.h).
const MAX_DEPTH: u32 = 94;

/// Deepest tree of one level; deeper parts are balanced anew. Enough for 2^29 triangles in balance and then some.
const LEVEL_DEPTH: u32 = MAX_DEPTH / 2;

/// More triangles than this get the faster of two builds.
const MANY: usize = 2_000_000;

/// A tree in the node array.
pub(super) struct Tree {
    /// Index of its root.
    pub root: u32,
    /// Levels.
    pub depth: u32,
    /// Primitives in the order of the leaves; some may stand twice, split between leaves.
    pub order: Vec<u32>,
}

/// A box as a primitive.
struct Boxed(Aabb);

impl Boundable for Boxed {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

/// Builds a tree over triangles. `first_leaf` is the index that the first triangle of `order` will have.
pub(super) fn over_triangles(
    corners: &[[DVec3; 3]],
    first_leaf: u32,
    quality: TreeQuality,
    nodes: &mut Vec<f32>,
) -> Result<Tree, Error> {
    let narrow = |p: DVec3| Vec3A::from(p.as_vec3());
    let triangles: Vec<Triangle> =
        corners.iter().map(|[a, b, c]| Triangle { v0: narrow(*a), v1: narrow(*b), v2: narrow(*c) }).collect();
    let quality = match quality {
        TreeQuality::Fast => BvhBuildParams::fast_build(),
        TreeQuality::Medium => BvhBuildParams::medium_build(),
        TreeQuality::Auto if triangles.len() > MANY => BvhBuildParams::medium_build(),
        TreeQuality::Slow | TreeQuality::Auto => BvhBuildParams::slow_build(),
    };
    let bvh = build_bvh2_from_tris(&triangles, quality, &mut Duration::default());
    let mut order = Vec::with_capacity(bvh.primitive_indices.len());
    let tree = write_nodes(&bvh, nodes, &mut |first, count| {
        let at = first_leaf + order.len() as u32;
        order.extend(&bvh.primitive_indices[first as usize..(first + count) as usize]);
        Child::Leaf { first: at, count }
    })?;
    Ok(Tree { order, ..tree })
}

/// Builds the top level over boxes; its leaves hold one box each, which name it themselves: `order` is empty.
pub(super) fn over_boxes(boxes: &[(DVec3, DVec3)], nodes: &mut Vec<f32>) -> Result<Tree, Error> {
    let boxes: Vec<Boxed> = boxes
        .iter()
        .map(|(lo, hi)| Boxed(Aabb::new(Vec3A::from(round_down(*lo)), Vec3A::from(round_up(*hi)))))
        .collect();
    let single = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::medium_build() };
    let bvh = build_bvh2(&boxes, single, &mut Duration::default());
    write_nodes(&bvh, nodes, &mut |first, _| Child::Leaf { first: bvh.primitive_indices[first as usize], count: 1 })
}

fn round_down(v: DVec3) -> Vec3 {
    Vec3::from_array(v.to_array().map(|x| (x as f32).next_down()))
}

fn round_up(v: DVec3) -> Vec3 {
    Vec3::from_array(v.to_array().map(|x| (x as f32).next_up()))
}

/// What a child of a node is.
#[derive(Clone, Copy)]
enum Child {
    Node(usize),
    Leaf { first: u32, count: u32 },
}

/// Appends the nodes of a tree, root first. `leaf` turns a range of obvhs's primitives into a leaf.
fn write_nodes(bvh: &Bvh2, nodes: &mut Vec<f32>, leaf: &mut dyn FnMut(u32, u32) -> Child) -> Result<Tree, Error> {
    let root = (nodes.len() / NODE_FLOATS) as u32;
    let mut deepest = 1;
    let fresh = |nodes: &mut Vec<f32>| {
        let index = nodes.len() / NODE_FLOATS;
        nodes.resize(nodes.len() + NODE_FLOATS, 0.0);
        index
    };
    let top = &bvh.nodes[0];
    let root_at = fresh(nodes);
    if top.prim_count > 0 {
        // A node has two children: a root that is a leaf is cut in two, or stands twice when there is nothing to cut.
        let half = top.prim_count / 2;
        let children = if half > 0 {
            [leaf(top.first_index, half), leaf(top.first_index + half, top.prim_count - half)]
        } else {
            let only = leaf(top.first_index, top.prim_count);
            [only, only]
        };
        for (side, child) in children.iter().enumerate() {
            put_child(nodes, root_at, side, &top.aabb, child);
        }
        return Ok(Tree { root, depth: 1, order: Vec::new() });
    }
    let sizes = Sizes::of(bvh);
    let mut stack = vec![(0usize, root_at, 1u32)];
    while let Some((from, to, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        if !sizes.allow(bvh, from, depth) {
            deepest = deepest.max(balance(bvh, &mut leaves_below(bvh, from), to, depth, nodes, leaf));
            continue;
        }
        for side in 0..2 {
            let node = &bvh.nodes[bvh.nodes[from].first_index as usize + side];
            let child = if node.prim_count > 0 {
                leaf(node.first_index, node.prim_count)
            } else {
                let at = fresh(nodes);
                stack.push((bvh.nodes[from].first_index as usize + side, at, depth + 1));
                Child::Node(at)
            };
            put_child(nodes, to, side, &node.aabb, &child);
        }
    }
    check_depth(deepest)?;
    Ok(Tree { root, depth: deepest, order: Vec::new() })
}

/// Levels and leaves below each node of a tree.
struct Sizes {
    height: Vec<u32>,
    leaves: Vec<u32>,
}

impl Sizes {
    fn of(bvh: &Bvh2) -> Sizes {
        let mut sizes = Sizes { height: vec![0; bvh.nodes.len()], leaves: vec![1; bvh.nodes.len()] };
        let mut inner = Vec::new();
        let mut stack = vec![0usize];
        while let Some(at) = stack.pop() {
            if bvh.nodes[at].prim_count == 0 {
                inner.push(at);
                let first = bvh.nodes[at].first_index as usize;
                stack.extend([first, first + 1]);
            }
        }
        // Parents stand before their children.
        for at in inner.into_iter().rev() {
            let first = bvh.nodes[at].first_index as usize;
            sizes.height[at] = 1 + sizes.height[first].max(sizes.height[first + 1]);
            sizes.leaves[at] = sizes.leaves[first] + sizes.leaves[first + 1];
        }
        sizes
    }

    /// Whether the node at this depth may be kept: the tree below it is flat enough, or can still be made so below its
    /// children.
    fn allow(&self, bvh: &Bvh2, node: usize, depth: u32) -> bool {
        let first = bvh.nodes[node].first_index as usize;
        let balanced = |n: usize| self.leaves[n].next_power_of_two().trailing_zeros();
        depth - 1 + self.height[node] <= LEVEL_DEPTH
            || (depth + balanced(first) <= LEVEL_DEPTH && depth + balanced(first + 1) <= LEVEL_DEPTH)
    }
}

/// The leaves of a subtree.
fn leaves_below(bvh: &Bvh2, node: usize) -> Vec<u32> {
    let mut leaves = Vec::new();
    let mut stack = vec![node];
    while let Some(at) = stack.pop() {
        let first = bvh.nodes[at].first_index as usize;
        match bvh.nodes[at].prim_count {
            0 => stack.extend([first + 1, first]),
            _ => leaves.push(at as u32),
        }
    }
    leaves
}

/// Writes node `to` over two or more leaves, cut in the middle of the longest axis again and again: many boxes in one place,
/// such as triangles without area, would else make a list of a tree. Returns the deepest level.
fn balance(
    bvh: &Bvh2,
    leaves: &mut [u32],
    to: usize,
    depth: u32,
    nodes: &mut Vec<f32>,
    leaf: &mut dyn FnMut(u32, u32) -> Child,
) -> u32 {
    let aabb = |l: &u32| bvh.nodes[*l as usize].aabb;
    let middle = |l: &u32| aabb(l).min * 0.5 + aabb(l).max * 0.5;
    let lo = leaves.iter().map(middle).fold(Vec3A::INFINITY, Vec3A::min);
    let hi = leaves.iter().map(middle).fold(Vec3A::NEG_INFINITY, Vec3A::max);
    let extent = hi - lo;
    let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
    let half = leaves.len() / 2;
    leaves.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(b)));
    let (left, right) = leaves.split_at_mut(half);
    let mut deepest = depth;
    for (side, part) in [left, right].into_iter().enumerate() {
        let (lo, hi) = part
            .iter()
            .map(aabb)
            .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(lo, hi), b| (lo.min(b.min), hi.max(b.max)));
        let child = match part {
            [only] => {
                let node = &bvh.nodes[*only as usize];
                leaf(node.first_index, node.prim_count)
            }
            _ => {
                let at = nodes.len() / NODE_FLOATS;
                nodes.resize(nodes.len() + NODE_FLOATS, 0.0);
                deepest = deepest.max(balance(bvh, part, at, depth + 1, nodes, leaf));
                Child::Node(at)
            }
        };
        put_child(nodes, to, side, &Aabb::new(lo, hi), &child);
    }
    deepest
}

/// Checks that both levels together fit the kernels' stack.
pub(super) fn check_depth(depth: u32) -> Result<(), Error> {
    if depth > MAX_DEPTH { Err(Error::TooDeep { depth, most: MAX_DEPTH }) } else { Ok(()) }
}

/// Where the numbers of a child lie in its node: least x, y, z; greatest x, y, z; index; count.
pub(super) fn child_places(side: usize) -> [usize; 8] {
    [0, 4, 8, 2, 6, 10, 12, 14].map(|first| first + side)
}

fn put_child(nodes: &mut [f32], node: usize, side: usize, aabb: &Aabb, child: &Child) {
    let node = &mut nodes[node * NODE_FLOATS..][..NODE_FLOATS];
    let (index, count) = match child {
        Child::Node(i) => (*i as u32, 0),
        Child::Leaf { first, count } => (*first, *count),
    };
    // Edges are stored as differences: a corner is off by the rounding of two numbers of the triangle's size.
    let slack = aabb.max.abs().max(aabb.min.abs()).max_element() * 4.0 * f32::EPSILON;
    let places = child_places(side);
    for k in 0..3 {
        node[places[k]] = aabb.min[k] - slack;
        node[places[3 + k]] = aabb.max[k] + slack;
    }
    node[places[6]] = f32::from_bits(index);
    node[places[7]] = f32::from_bits(count);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(at: f64) -> [DVec3; 3] {
        [DVec3::new(at, 0.0, 0.0), DVec3::new(at + 1.0, 0.0, 0.0), DVec3::new(at, 1.0, 0.0)]
    }

    #[test]
    fn a_single_triangle_is_both_children_of_the_root() {
        let mut nodes = Vec::new();
        let tree = over_triangles(&[triangle(0.0)], 5, TreeQuality::Auto, &mut nodes).expect("builds");
        assert_eq!((nodes.len(), tree.root, tree.order.as_slice()), (16, 0, &[0u32][..]));
        assert_eq!([12, 13, 14, 15].map(|i: usize| nodes[i].to_bits()), [5, 5, 1, 1]);
    }

    #[test]
    fn triangles_in_one_place_make_no_list() {
        let mut corners = vec![[DVec3::ONE; 3]; 500];
        corners.push(triangle(0.0));
        let tree = over_triangles(&corners, 0, TreeQuality::Auto, &mut Vec::new()).expect("builds");
        assert!(tree.depth <= LEVEL_DEPTH, "{}", tree.depth);
        let found: std::collections::BTreeSet<u32> = tree.order.iter().copied().collect();
        assert_eq!(found.len(), corners.len());
        let boxes = vec![(DVec3::ZERO, DVec3::ONE); 500];
        assert!(over_boxes(&boxes, &mut Vec::new()).expect("builds").depth <= LEVEL_DEPTH);
    }

    #[test]
    fn leaves_cover_all_triangles_and_boxes_contain_them() {
        let triangles: Vec<_> = (0..100).map(|i| triangle(f64::from(i) * 1.5)).collect();
        let mut nodes = Vec::new();
        let tree = over_triangles(&triangles, 0, TreeQuality::Auto, &mut nodes).expect("builds");
        let mut seen = [false; 100];
        for node in nodes.chunks(16) {
            for child in [0, 1].map(|side| child_places(side).map(|place| node[place])) {
                let (first, count) = (child[6].to_bits(), child[7].to_bits());
                for leaf in first..first + count {
                    let original = tree.order[leaf as usize] as usize;
                    seen[original] = true;
                    assert!(f64::from(child[0]) <= triangles[original][0].x);
                    assert!(f64::from(child[3]) >= triangles[original][1].x || tree.order.len() > 100);
                }
            }
        }
        assert!(seen.iter().all(|s| *s));
    }
}
