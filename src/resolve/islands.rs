//! Bodies that nothing holds and that have no mass: nothing says how they move.

use super::Resolver;
use super::names::Named;
use crate::diagnostic::fault::Fault;
use crate::diagnostic::span::Text;
use crate::diagnostic::suggest;
use crate::model::{Body, Formula};

impl Resolver<'_> {
    /// Joints and position drivers connect bodies to each other and to the ground; an island of bodies that has
    /// neither a way to the ground nor a mass is a fault.
    pub(super) fn islands(&mut self, bodies: &[Body]) {
        let scene = self.scene;
        let ground = bodies.len();
        let mut islands = Islands::new(ground + 1);
        let mut connect = |a: Option<usize>, b: Option<usize>| {
            // A point that does not exist has its own fault; its body is not to get another.
            islands.join(a.unwrap_or(ground), b.unwrap_or(ground));
        };
        for joint in &scene.joints {
            if let Some([first, second]) = joint.between() {
                connect(self.owner_index(&first), self.owner_index(&second));
            }
        }
        for on in scene.drivers.iter().filter_map(|driver| driver.text("on")) {
            connect(self.owner_index(&on), None);
        }
        if self.incomplete || !scene.broken.is_empty() {
            return;
        }
        let mut members: Vec<Vec<&Body>> = vec![Vec::new(); ground + 1];
        for (index, body) in bodies.iter().enumerate() {
            members[islands.root(index)].push(body);
        }
        members[islands.root(ground)].clear();
        for island in members {
            if let Some(first) = island.first()
                && island.iter().all(|body| is_massless(body))
            {
                self.floating(first, &island);
            }
        }
    }

    fn floating(&mut self, first: &Body, island: &[&Body]) {
        let names = suggest::list(island.iter().map(|body| body.name.as_str()));
        let help = if island.len() == 1 {
            "give it a mass, or join it to the ground"
        } else {
            "give one of them a mass, or join one of them to the ground"
        };
        let message = match island {
            [_] => format!("body {names} has no mass and is not connected to any other body"),
            _ => format!("bodies {names} have no mass and are connected to each other only"),
        };
        self.faults
            .push(Fault::new("scene::floating", message, first.span).label("its motion is not determined").help(help));
    }

    fn owner_index(&self, point: &Text) -> Option<usize> {
        match self.names.get(point.text.split('.').next().unwrap_or_default()) {
            Some(Named::Body(id)) => Some(id.0),
            _ => None,
        }
    }
}

fn is_massless(body: &Body) -> bool {
    matches!(body.mass, None | Some(Formula::Number(0.0)))
}

struct Islands {
    parent: Vec<usize>,
}

impl Islands {
    fn new(count: usize) -> Islands {
        Islands { parent: (0..count).collect() }
    }

    fn root(&mut self, mut index: usize) -> usize {
        while self.parent[index] != index {
            // Halving the path keeps it short.
            self.parent[index] = self.parent[self.parent[index]];
            index = self.parent[index];
        }
        index
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a] = b;
    }
}
